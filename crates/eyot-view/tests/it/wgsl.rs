//! The drawing shaders are sound, wherever there is a GPU or none.

use eyot_view::shaders;

/// Checks a module as a device with WebGPU's features does, and counts its storage bindings.
fn storage_bindings(name: &str, source: &str) -> usize {
    let module =
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(source)));
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(source)));
    let is_storage =
        |t: &naga::TypeInner| matches!(t, naga::TypeInner::Image { class: naga::ImageClass::Storage { .. }, .. });
    module.global_variables.iter().filter(|(_, v)| is_storage(&module.types[v.ty].inner)).count()
}

#[test]
fn shaders_validate_and_keep_to_webgpu_limits() {
    assert_eq!(storage_bindings("picture", &shaders::picture()), 0);
    // WebGPU promises four storage textures a stage.
    assert_eq!(storage_bindings("maps", shaders::MAPS), 4);
    assert_eq!(storage_bindings("card", shaders::CARD), 2);
    assert_eq!(storage_bindings("mips", shaders::MIPS), 1);
}

#[test]
fn a_shader_that_is_not_sound_is_found() {
    let broken = shaders::picture().replacen("fn is_sea() -> bool", "fn is_sea() -> f32", 1);
    assert!(std::panic::catch_unwind(|| storage_bindings("broken", &broken)).is_err());
}
