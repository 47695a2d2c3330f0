//! A build without Vulkan: nothing can be attached, so nothing of this is ever made.

use super::super::buffer::BufferEntry;
use super::super::ids::Slots;
use super::super::instance::InstanceEntry;
use super::super::load::not_built;
use super::super::recording::Log;
use super::super::result::Failure;
use super::super::types::CrumpleBuffer;
use super::{
    CrumpleHandleType, CrumpleRecordReport, CrumpleVulkanAttachDef, CrumpleVulkanBufferDef, CrumpleVulkanImportDef,
    CrumpleVulkanOpenDef,
};
use crate::{Aabb, Instance};
use std::ffi::c_void;
use std::ops::Range;

pub(in super::super) enum Attached {}

pub(in super::super) enum VulkanMemory {}

type Buffers<'a> = (*const CrumpleBuffer, &'a [CrumpleBuffer]);
type Entries<'a> = (&'a mut Slots<BufferEntry>, &'a mut Slots<InstanceEntry>);

impl Attached {
    pub(super) unsafe fn new(_: &CrumpleVulkanAttachDef, _: &[u8]) -> Result<Self, Failure> {
        Err(not_built("vulkan"))
    }

    pub(in super::super) fn check_idle(&self) -> Result<(), Failure> {
        match *self {}
    }

    pub(super) fn pipeline_cache(&mut self) -> Result<Vec<u8>, Failure> {
        match *self {}
    }

    pub(super) unsafe fn register(
        &mut self,
        _: &Instance,
        _: &CrumpleVulkanBufferDef,
    ) -> Result<VulkanMemory, Failure> {
        match *self {}
    }

    pub(in super::super) fn remove(&mut self, memory: VulkanMemory) -> Result<(), Failure> {
        match memory {}
    }

    pub(super) unsafe fn record(
        &mut self,
        _: (*mut c_void, u64),
        _: Buffers<'_>,
        _: Entries<'_>,
        _: &mut Log<'_>,
    ) -> Result<CrumpleRecordReport, Failure> {
        match *self {}
    }

    pub(super) fn complete(&mut self, _: u64) -> Result<(), Failure> {
        match *self {}
    }

    pub(super) fn discard(&mut self, _: u64) -> Result<(), Failure> {
        match *self {}
    }

    pub(super) unsafe fn open(_: &CrumpleVulkanOpenDef, _: &[u8]) -> Result<Self, Failure> {
        Err(not_built("vulkan"))
    }

    pub(super) unsafe fn import_buffer(&mut self, _: &CrumpleVulkanImportDef) -> Result<u64, Failure> {
        match *self {}
    }

    pub(super) fn release_buffer(&mut self, _: u64) -> Result<(), Failure> {
        match *self {}
    }

    pub(super) unsafe fn import_semaphore(&mut self, _: CrumpleHandleType, _: i64) -> Result<u64, Failure> {
        match *self {}
    }

    pub(super) fn submit(
        &mut self,
        _: Buffers<'_>,
        _: Entries<'_>,
        _: (&[u64], &[u64]),
        _: &mut Log<'_>,
    ) -> Result<(u64, CrumpleRecordReport), Failure> {
        match *self {}
    }

    pub(super) fn wait(&mut self, _: u64, _: u64) -> Result<bool, Failure> {
        match *self {}
    }
}

impl VulkanMemory {
    pub(in super::super) fn written(&self) -> (bool, bool) {
        match *self {}
    }

    pub(in super::super) fn invalidate(&mut self) {
        match *self {}
    }

    pub(in super::super) fn changed(&self) -> &[Range<u32>] {
        match *self {}
    }

    pub(in super::super) fn bounds(&self) -> Option<Aabb> {
        match *self {}
    }

    pub(super) fn discard(&mut self, _: u64) {
        match *self {}
    }
}
