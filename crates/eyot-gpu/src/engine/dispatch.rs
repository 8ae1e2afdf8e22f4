//! Plans as dispatches, and their submissions.

use super::resident::Resident;
use super::timer::{MAX_TIMED, Timer};
use super::{GpuEngine, IN_FLIGHT, MAX_DISPATCHES};
use crate::error::{GpuError, Result};
use crate::group::{Group, JOB_WORDS, Layers, TILE, groups};
use crate::shader::{self, Setting};
use eyot_core::graph::Graph;
use eyot_core::plan::{Pass, Plan};
use std::sync::Arc;

/// A group that is ready to run.
pub(super) struct Kernel {
    pipeline: wgpu::ComputePipeline,
    outer: [usize; 2],
    bytes_per_cell: usize,
}

/// Dispatches that have not gone to the card yet.
#[derive(Default)]
pub(super) struct Batch {
    jobs: Vec<u32>,
    pub(super) dispatches: Vec<Dispatch>,
    /// Steps that are complete with them.
    pub(super) steps: u64,
}

/// One dispatch of a submission.
pub(super) struct Dispatch {
    kernel: Arc<Kernel>,
    slab: usize,
    job: u32,
    tiles: [u32; 2],
    last_of_group: bool,
}

/// Why a resident world cannot go on as it is.
pub(crate) enum Misfit {
    /// A layer, copy or account is needed that it was not made for.
    Rebuild,
    Failed(GpuError),
}

impl From<GpuError> for Misfit {
    fn from(e: GpuError) -> Self {
        Self::Failed(e)
    }
}

impl GpuEngine {
    /// Adds a plan of whole steps, or a part of one step, to the batch, which goes to the card as often as the pace asks for.
    pub(crate) fn submit(&mut self, plan: &Plan, steps: u64) -> Result<(), Misfit> {
        let Some(mut r) = self.resident.take() else {
            return Err(GpuError::Fault("no world is on the card".into()).into());
        };
        let outcome = self.submit_to(&mut r, plan);
        self.resident = Some(r);
        outcome?;
        self.batch.steps += steps;
        Ok(())
    }

    fn submit_to(&mut self, r: &mut Resident, plan: &Plan) -> Result<(), Misfit> {
        let passes = plan.passes();
        let layers = Layers { specs: &r.specs, world_layers: r.world_layers };
        let groups = groups(passes, &layers, self.bounds(&r.arena.grid)).ok_or(Misfit::Rebuild)?;
        r.check_room(&groups, passes)?;
        // What was on its way back is out of date.
        (r.coming, r.checks) = (None, Vec::new());
        let mut first = 0;
        for group in &groups {
            let of_group = &passes[first..first + group.stages.len()];
            first += group.stages.len();
            let waiting = self.batch.dispatches.len();
            if waiting >= self.pace.most || waiting + r.arena.slabs.len() > MAX_DISPATCHES {
                self.flush(r)?;
            }
            let kernel = self.kernel(r, group, of_group)?;
            r.dispatch(group, of_group, &kernel, &mut self.batch);
            self.work.bytes += (kernel.bytes_per_cell * r.arena.grid.cells()) as u64;
            for &(layer, elsewhere) in &group.outputs {
                if elsewhere {
                    r.current[layer] = 1 - r.current[layer];
                }
                if layer < r.world_layers {
                    r.stale[layer] = true;
                }
            }
        }
        Ok(())
    }

    /// Sends what is left of the batch and waits until the card has nothing to do.
    pub(crate) fn finish(&mut self) -> Result<()> {
        if let Some(r) = self.resident.take() {
            let outcome = self.flush(&r);
            self.resident = Some(r);
            outcome?;
        }
        self.pace.wait(&self.gpu, 0, self.options.submission, self.options.polled)
    }

    /// Submits the batch, and keeps the pace.
    fn flush(&mut self, r: &Resident) -> Result<()> {
        let passes = if r.arena.split() { self.batch.dispatches.len() / r.arena.slabs.len() } else { 1 };
        if self.timer.as_ref().is_some_and(|t| t.used as usize + passes > MAX_TIMED as usize) {
            self.read_timer()?;
        }
        let Batch { jobs, dispatches, steps } = &mut self.batch;
        if dispatches.is_empty() {
            self.pace.done += std::mem::take(steps);
            return Ok(());
        }
        self.gpu.queue.write_buffer(&self.job, 0, bytemuck::cast_slice(jobs));
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut next = 0;
        while next < dispatches.len() {
            // Between slabs rows must be shared, which cannot be done inside a pass.
            let end = if r.arena.split() {
                next + 1
                    + dispatches[next..].iter().position(|d| d.last_of_group).unwrap_or(dispatches.len() - next - 1)
            } else {
                dispatches.len()
            };
            let timestamp_writes = self.timer.as_ref().and_then(Timer::writes);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
            for d in &dispatches[next..end] {
                pass.set_pipeline(&d.kernel.pipeline);
                pass.set_bind_group(0, &r.arena.slabs[d.slab].bind, &[d.job]);
                pass.dispatch_workgroups(d.tiles[0], d.tiles[1], 1);
            }
            drop(pass);
            if let Some(timer) = &mut self.timer {
                timer.used = (timer.used + 1).min(MAX_TIMED);
            }
            r.arena.share(&mut encoder);
            next = end;
        }
        self.work.submissions += 1;
        self.work.dispatches += dispatches.len() as u64;
        let index = self.gpu.queue.submit([encoder.finish()]);
        self.pace.begun(&self.gpu, index, dispatches.len(), std::mem::take(steps), self.options.polled);
        jobs.clear();
        dispatches.clear();
        self.gpu.check()?;
        // A plan that goes to the card in part cannot be refused; the next one is.
        if self.options.polled { Ok(()) } else { self.keep_pace() }
    }

    /// Waits until one submission less than may be is under way.
    pub(crate) fn keep_pace(&mut self) -> Result<()> {
        self.pace.wait(&self.gpu, IN_FLIGHT - 1, self.options.submission, self.options.polled)
    }

    /// The pipeline of a group, compiled when it is first needed.
    fn kernel(&mut self, r: &mut Resident, group: &Group, passes: &[Pass]) -> Result<Arc<Kernel>> {
        if let Some(kernel) = r.kernels.get(group) {
            return Ok(Arc::clone(kernel));
        }
        let graphs: Vec<Arc<Graph>> = passes
            .iter()
            .map(|p| Arc::clone(r.graphs.entry(p.kind()).or_insert_with(|| Arc::new(p.graph()))))
            .collect();
        let graphs: Vec<&Graph> = graphs.iter().map(|g| &**g).collect();
        let setting = Setting { specs: &r.specs, rim: r.arena.grid.rim, split: r.arena.split() };
        let source = shader::wgsl(group, &graphs, setting);
        let pipeline = match self.pipelines.get(&source) {
            Some(p) => p.clone(),
            None => {
                let p = self.compile(passes[0].name(), &source)?;
                self.pipelines.insert(source, p.clone());
                p
            }
        };
        let outer = group.outer_faces(&r.specs, r.arena.grid.rim);
        let kernel = Arc::new(Kernel { pipeline, outer, bytes_per_cell: group.bytes_per_cell() });
        r.kernels.insert(group.clone(), Arc::clone(&kernel));
        Ok(kernel)
    }

    fn compile(&mut self, name: &str, source: &str) -> Result<wgpu::ComputePipeline> {
        let (pipeline, error) = self.gpu.scoped(wgpu::ErrorFilter::Validation, || {
            let module = self.gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
            self.gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&self.pipeline_layout),
                module: &module,
                entry_point: Some("main"),
                // A workgroup writes its memory before it reads it.
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..Default::default()
                },
                cache: self.cache.as_ref(),
            })
        });
        self.work.pipelines += 1;
        match error {
            Some(e) => Err(GpuError::Fault(format!("rule `{name}`: {e}"))),
            None => self.gpu.check().map(|()| pipeline),
        }
    }
}

impl Resident {
    /// Finds slots and accounts that the groups need and that are not there.
    fn check_room(&self, groups: &[Group], passes: &[Pass]) -> Result<(), Misfit> {
        let mut current = self.current.clone();
        for group in groups {
            let there = |l: usize, copy: usize| self.slots.contains_key(&(l, copy));
            let inputs = group.inputs.iter().all(|&l| there(l, current[l]));
            for &(l, elsewhere) in &group.outputs {
                if elsewhere {
                    current[l] = 1 - current[l];
                }
            }
            if !inputs || !group.outputs.iter().all(|&(l, _)| there(l, current[l])) {
                return Err(Misfit::Rebuild);
            }
        }
        let mut tallies = passes.iter().flat_map(|p| p.tallies());
        if tallies.any(|t| self.account(t).is_none()) {
            return Err(Misfit::Rebuild);
        }
        Ok(())
    }

    /// Adds the dispatches of a group, one a slab.
    fn dispatch(&self, group: &Group, passes: &[Pass], kernel: &Arc<Kernel>, batch: &mut Batch) {
        let Batch { jobs, dispatches, .. } = batch;
        let (a, g) = (&self.arena, &self.arena.grid);
        for (n, slab) in a.slabs.iter().enumerate() {
            let outer = [kernel.outer[0], if n == 0 { kernel.outer[1] } else { 0 }];
            let (left, top) = (-(outer[0] as i32), slab.first as i32 - outer[1] as i32);
            let start = jobs.len();
            let end_row = slab.first + slab.rows;
            // In the order of `shader::job_fields`.
            let head = [g.width as i32, g.height as i32, left, top, a.first_row(slab), end_row as i32];
            jobs.extend(head.map(|v| v as u32));
            jobs.extend([a.stride, a.slots, slab.first_group, a.groups].map(|v| v as u32));
            jobs.extend(group.inputs.iter().map(|&l| self.slots[&(l, self.current[l])] as u32));
            jobs.extend(group.outputs.iter().map(|&(l, elsewhere)| {
                let copy = if elsewhere { 1 - self.current[l] } else { self.current[l] };
                self.slots[&(l, copy)] as u32
            }));
            for pass in passes {
                if self.graphs.get(&pass.kind()).is_some_and(|g| shader::is_random(g)) {
                    let key = pass.key(self.seed);
                    jobs.extend([key.low, key.high]);
                }
                jobs.extend(pass.params().iter().map(|p| p.to_bits()));
                jobs.extend(pass.tallies().iter().map(|t| self.account(t).unwrap_or_default() as u32));
            }
            jobs.resize(start + JOB_WORDS, 0);
            let tiles =
                [(g.width + outer[0]).div_ceil(TILE[0]) as u32, (slab.rows + outer[1]).div_ceil(TILE[1]) as u32];
            dispatches.push(Dispatch {
                kernel: Arc::clone(kernel),
                slab: n,
                job: 4 * start as u32,
                tiles,
                last_of_group: n + 1 == a.slabs.len(),
            });
        }
    }
}
