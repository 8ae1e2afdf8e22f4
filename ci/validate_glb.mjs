// Prints Khronos' verdict on each GLB file as one line of JSON. Usage: node validate_glb.mjs FILE...
import { readFile } from "node:fs/promises";
import validator from "gltf-validator";

for (const file of process.argv.slice(2)) {
  try {
    const bytes = new Uint8Array(await readFile(file));
    const { issues } = await validator.validateBytes(bytes, { uri: file, maxIssues: 50 });
    const messages = issues.messages.map((m) => `${["error", "warning", "info", "hint"][m.severity]} ${m.code} ${m.pointer ?? ""}: ${m.message}`);
    console.log(JSON.stringify({ file, errors: issues.numErrors, warnings: issues.numWarnings, infos: issues.numInfos, messages }));
  } catch (e) {
    console.log(JSON.stringify({ file, errors: 1, warnings: 0, infos: 0, messages: [String(e)] }));
  }
}
