//! Instruction sets: the same kernels are compiled for each, and the best one is chosen when the program runs.

// Reason for the exception: functions compiled for an instruction set may only be called where the processor has it.

use crate::lanes::{LaneBlock, Lanes};
use std::sync::atomic::{AtomicU8, Ordering};

/// Where [`Isa::best`] ends.
static MOST: AtomicU8 = AtomicU8::new(u8::MAX);

/// How a row of cells is computed. Every choice gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Isa {
    /// One cell at a time; the reference.
    Scalar,
    /// Lanes with what every processor of this architecture has (SSE2 on x86-64, NEON on AArch64).
    Baseline,
    /// Lanes with AVX2.
    Avx2,
    /// Lanes with AVX-512 (F, VL, BW, DQ).
    Avx512,
}

impl Isa {
    /// All of them, slowest first.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Baseline, Self::Avx2, Self::Avx512];

    /// The best one that this processor has, up to what [`Isa::use_at_most`] allows.
    pub fn best() -> Self {
        let most = MOST.load(Ordering::Relaxed);
        let allowed = |i: &Self| i.is_available() && *i as u8 <= most;
        Self::ALL.into_iter().rev().find(allowed).unwrap_or(Self::Scalar)
    }

    /// Keeps [`Isa::best`] at this one or a lesser one from now on, in the whole program. Results stay the same to the bit, so
    /// this is for measuring and for looking into trouble with a processor.
    pub fn use_at_most(self) {
        MOST.store(self as u8, Ordering::Relaxed);
    }

    /// True if this processor can run it.
    pub fn is_available(self) -> bool {
        match self {
            Self::Scalar | Self::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => std::arch::is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                use std::arch::is_x86_feature_detected as has;
                has!("avx512f") && has!("avx512vl") && has!("avx512bw") && has!("avx512dq")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// Lower-case name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Baseline => "baseline",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

/// Work that is written once for any type of lanes.
///
/// `run` and everything below it must be `#[inline(always)]`, closures avoided (they cannot be marked): what is not
/// inlined is compiled for the baseline and slow, though right.
pub trait LaneTask {
    /// What it gives back.
    type Out;
    /// The work.
    fn run<L: LaneBlock>(self) -> Self::Out;
}

/// Runs `task` in the lanes of `isa`; [`Isa::Scalar`] counts as the baseline here.
///
/// # Panics
/// If the processor does not have this instruction set.
#[allow(unsafe_code)]
pub fn run_lanes<T: LaneTask>(isa: Isa, task: T) -> T::Out {
    #[cfg(target_arch = "x86_64")]
    {
        use crate::lanes::x86::{Avx2, Avx512};
        #[target_feature(enable = "avx2")]
        fn avx2<T: LaneTask>(task: T) -> T::Out {
            task.run::<Avx2>()
        }
        #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq")]
        fn avx512<T: LaneTask>(task: T) -> T::Out {
            task.run::<Avx512>()
        }
        assert!(isa.is_available(), "this processor has no {}", isa.name());
        match isa {
            // SAFETY: the processor has what the function was compiled for.
            Isa::Avx2 => return unsafe { avx2(task) },
            // SAFETY: as above.
            Isa::Avx512 => return unsafe { avx512(task) },
            Isa::Scalar | Isa::Baseline => {}
        }
    }
    let _ = isa;
    task.run::<Lanes>()
}
