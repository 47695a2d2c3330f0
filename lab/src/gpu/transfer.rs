//! Onto the device and back: the upload of a set with its first target, and reading vertices back, which is what an engine that
//! deforms on the device never needs (the paper's Figure 5.6).

use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use crumple::{ExampleSet, InstanceOptions};

use super::Bench;
use super::buffer::{Buffer, Place};
use super::check::{Agreement, ULPS};
use super::copy::Copy;
use super::findings::Finding;
use super::recorded::{Output, Recorded, marked};
use super::scene::{STRENGTHS, at_strength, sheet};
use crate::bench::measure::{Contender, Times};
use crate::bench::report::Sense;
use crate::bench::sheet::{Dent, own_marks};

pub fn run(bench: &Bench<'_>, sizes: &[usize]) -> Result<()> {
    for size in sizes {
        bench.fits(&format!("transfer, {size}"), one(bench, *size))?;
    }
    Ok(())
}

fn one(bench: &Bench<'_>, size: usize) -> Result<()> {
    let set = sheet(size, &[Dent::whole([0.5; 2])], false, &bench.tasks)?;
    upload(bench, &set)?;
    read_back(bench, &set)
}

/// A set comes onto the device: into a staging buffer when its first target is added, and from there by the next recording.
fn upload(bench: &Bench<'_>, set: &Arc<ExampleSet>) -> Result<()> {
    let (gpu, tasks, vertices) = (bench.gpu, &bench.tasks, set.vertex_count());
    // Something to record, so small that it counts for nothing, and the pipeline that both take.
    let small = sheet(64, &[Dent::whole([0.5; 2])], false, tasks)?;
    let body = |set: &Arc<ExampleSet>| {
        let marks = at_strength(&own_marks(set)?, STRENGTHS[0]);
        marked(set, InstanceOptions::default(), &marks)
    };
    let (mut added, mut copied, mut bytes, mut agreement) = (Vec::new(), Vec::new(), 0, None);
    for _ in 0..bench.plan.least.min(7) {
        let mut first = Recorded::one(gpu, body(&small)?, Output::Positions)?;
        first.frame()?;
        let (took, cost, mut uploaded) = first.upload(body(set)?)?;
        added.push(took.as_secs_f64());
        copied.push(cost.device.as_secs_f64());
        bytes = cost.report.bytes_copied;
        if agreement.is_none() {
            let wanted = uploaded.expected(tasks)?;
            agreement = Some(Agreement::of(gpu, "what was uploaded", (&uploaded.written()?, &wanted), ULPS)?);
        }
    }
    // The same bytes from memory of the same kind, and on the CPU.
    let mut staging = Buffer::new(gpu, bytes, Place::Upload)?;
    let words = vec![0x5A5A_5A5A_u32; bytes as usize / 4];
    let to = gpu.local(bytes)?;
    let memcpy = std::cell::RefCell::new(Vec::new());
    let [device] = bench.measure([Contender::new(|| {
        let start = Instant::now();
        staging.words_mut().copy_from_slice(&words);
        memcpy.borrow_mut().push(start.elapsed().as_secs_f64());
        gpu.timed(|c| gpu.copy(c, &staging, &to, bytes)).unwrap_or_else(|e| panic!("{e:#}"))
    })]);
    let memcpy = Times::new(memcpy.into_inner());
    let found = |method: &str, times: Vec<f64>| {
        Finding::time("transfer", method, "", vertices, &Times::new(times), "ms").bytes(bytes as f64 / vertices as f64)
    };
    for (finding, name, reference) in
        [(found("upload cpu", added), "memcpy", &memcpy), (found("upload device", copied), "copy", &device)]
    {
        let finding = finding.beside(name, reference, Sense::Cost);
        bench.add(match agreement {
            Some(agreement) => finding.checked(agreement),
            None => finding,
        });
    }
    Ok(())
}

/// The vertices of a deformation into memory of the CPU, against the deformation itself.
fn read_back(bench: &Bench<'_>, set: &Arc<ExampleSet>) -> Result<()> {
    let (gpu, vertices) = (bench.gpu, set.vertex_count());
    let marks = at_strength(&own_marks(set)?, STRENGTHS[0]);
    let mut body = Recorded::one(gpu, marked(set, InstanceOptions::default(), &marks)?, Output::Positions)?;
    body.frame()?;
    let seen = Buffer::new(gpu, body.vertex_buffer().size, Place::ReadBack)?;
    let mut result = vec![0u32; seen.size as usize / 4];
    let mut copy = Copy::of(gpu, result.len())?;
    let back = || gpu.timed(|c| body.vertex_buffer().to_host(c, &seen)).unwrap_or_else(|e| panic!("{e:#}"));
    let [device, cpu, whole, within] = bench.measure([
        Contender::new(back),
        Contender::new(|| {
            let start = Instant::now();
            std::hint::black_box(seen.words().to_vec());
            start.elapsed()
        }),
        Contender::new(|| {
            let start = Instant::now();
            back();
            result.copy_from_slice(seen.words());
            start.elapsed()
        }),
        Contender::new(|| copy.run()),
    ]);
    copy.check()?;
    let wanted = body.expected(&bench.tasks)?;
    let agreement = Agreement::of(gpu, "what was read back", (bytemuck::cast_slice(&result), &wanted), ULPS)?;
    let [deformed] = bench.measure([Contender::new(|| body.run_all())]);
    let found = |method: &str, times| {
        Finding::time("transfer", method, "", vertices, times, "ms").bytes(12.0).checked(agreement)
    };
    bench.add(found("back device", &device).beside("copy", &within, Sense::Cost));
    bench.add(found("back cpu", &cpu));
    bench.add(found("back", &whole).beside("deforming", &deformed, Sense::Cost));
    Ok(())
}
