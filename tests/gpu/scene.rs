//! Instances whose vertices are shown in one buffer.

use std::sync::Arc;

use crumple::{ExampleSet, Instance};

use super::compare::Expected;
use super::folded;
use super::layout::TestLayout;
use crate::backend::{Buffer, Gpu, Job, Report, Target};

/// Some instances, their places in a buffer, and what it should hold.
pub struct Scene {
    pub instances: Vec<Instance>,
    pub targets: Vec<Target>,
    pub layouts: Vec<TestLayout>,
    pub buffer: Buffer,
    expected: Expected,
}

impl Scene {
    /// Every attribute of these instances, with gaps between them.
    pub fn new(gpu: &mut Gpu, instances: Vec<Instance>) -> Self {
        let mut at = 12;
        let mut place = |instance: &Instance| {
            let layout = TestLayout::everything(instance.example_set(), 0, at);
            at += layout.size + 8;
            layout
        };
        let layouts = instances.iter().map(&mut place).collect();
        Self::at(gpu, instances, layouts)
    }

    /// One instance with so many hits.
    pub fn of(gpu: &mut Gpu, set: &Arc<ExampleSet>, hits: usize, seed: u64) -> Self {
        Self::new(gpu, vec![folded(set, hits, seed)])
    }

    pub fn at(gpu: &mut Gpu, instances: Vec<Instance>, layouts: Vec<TestLayout>) -> Self {
        let end = layouts.iter().map(|l| l.offset + l.size).max().unwrap();
        let buffer = gpu.buffer(end + 64);
        let shown = instances.iter().zip(&layouts);
        let targets = shown.map(|(i, l)| gpu.add_target(i.example_set(), l, &buffer).unwrap()).collect();
        let expected = Expected::poison(buffer.words());
        Scene { instances, targets, layouts, buffer, expected }
    }

    pub fn jobs(&mut self) -> Vec<Job<'_>> {
        self.instances.iter().zip(&mut self.targets).map(|(instance, target)| Job { instance, target }).collect()
    }

    /// Writes what changed.
    pub fn run(&mut self, gpu: &mut Gpu) -> Report {
        gpu.run(&mut self.jobs()).unwrap()
    }

    /// From now on the buffer should hold these instances as they are now.
    pub fn expect(&mut self, which: impl IntoIterator<Item = usize>) {
        for i in which {
            self.layouts[i].expect(&mut self.instances[i], &mut self.expected);
        }
    }

    /// Fails if the buffer holds anything but what is expected.
    #[track_caller]
    pub fn compare(&self, gpu: &mut Gpu, what: &str) {
        self.expected.compare(&gpu.read(&self.buffer), &gpu.device, what);
    }

    /// Fails if the buffer does not hold all instances as they are now.
    #[track_caller]
    pub fn check(&mut self, gpu: &mut Gpu, what: &str) {
        self.expect(0..self.instances.len());
        self.compare(gpu, what);
    }
}
