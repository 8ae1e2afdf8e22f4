//! In the place of graphics cards, where the program is built without them.

use crate::artist::ViewRequest;
use eyot_core::engine::{DeviceError, EngineError};
use eyot_core::{Limits, World};
use eyot_render::{Camera, Picture, Stage};

/// There is none.
pub(crate) enum Card {}

impl Card {
    pub(crate) fn open(_: &World, _: &ViewRequest, _: &Limits) -> Result<Self, EngineError> {
        let reason = "this program draws with the processor alone";
        Err(EngineError::Device(DeviceError {
            lost: false,
            refused: true,
            sentence: reason.into(),
            source: reason.into(),
        }))
    }

    pub(crate) fn name(&self) -> String {
        match *self {}
    }

    pub(crate) fn stage(&self) -> &Stage {
        match *self {}
    }

    pub(crate) fn follow(&mut self, _: &World) -> Result<(), DeviceError> {
        match *self {}
    }

    pub(crate) fn draw(&mut self, _: &Camera, _: [u32; 2], _: f32) -> Result<Picture, DeviceError> {
        match *self {}
    }
}
