//! The devices that tests run on.

use crumple::wgpu::wgpu;
use crumple::wgpu::{Device, DeviceDef, HeadlessDef, adapters};

/// A word that nothing ever writes.
pub const POISON: u32 = 0xCDCD_CDCD;

/// Software drivers that every test runs on, as their names begin.
pub const DRIVERS: [&str; 2] = ["llvmpipe", "SwiftShader"];

pub fn required() -> bool {
    std::env::var("CRUMPLE_REQUIRE_GPU").is_ok_and(|v| v == "1")
}

/// Says aloud which of the software drivers are not among these devices; fails where they are required.
pub fn note_missing(seen: &[String]) {
    for driver in DRIVERS {
        if !seen.iter().any(|name| name.starts_with(driver)) {
            assert!(!required(), "{driver} is required, but there are only {seen:?}");
            eprintln!("left out: there is no {driver}, only {seen:?}");
        }
    }
}

/// Runs a test on each Vulkan device there is. Software drivers that are not there are left out, aloud; with
/// CRUMPLE_REQUIRE_GPU=1 they must be there.
pub fn on_each_device(test: impl Fn(&Gpu)) {
    let names: Vec<String> = adapters(wgpu::Backends::VULKAN).into_iter().map(|a| a.name).collect();
    for name in &names {
        now_on(name);
        test(&Gpu { name: name.clone() });
    }
    note_missing(&names);
}

thread_local! {
    static EXACT: std::cell::Cell<bool> = const { std::cell::Cell::new(true) };
}

/// Notes which device this thread tests.
pub fn now_on(name: &str) {
    EXACT.set(DRIVERS.iter().any(|driver| name.starts_with(driver)));
}

/// Whether the device under test rounds as IEEE 754 says: the software drivers do.
pub fn exact() -> bool {
    EXACT.get()
}

/// One device, told by its name.
pub struct Gpu {
    pub name: String,
}

impl Gpu {
    pub fn def(&self) -> HeadlessDef<'_> {
        HeadlessDef { adapter: Some(&self.name), backends: wgpu::Backends::VULKAN, device: DeviceDef::default() }
    }

    pub fn crumple(&self) -> Device {
        Device::headless(&self.def()).unwrap()
    }

    /// Two devices of a host, without features, with such limits: whatever the adapter has, changed by `change`.
    pub fn hosts(&self, change: impl Fn(&mut wgpu::Limits)) -> [(wgpu::Device, wgpu::Queue); 2] {
        let instance = wgpu::Instance::default();
        let adapters = at_once(instance.enumerate_adapters(wgpu::Backends::VULKAN));
        let adapter = adapters.iter().find(|a| a.get_info().name == self.name).unwrap();
        let mut required_limits = adapter.limits();
        change(&mut required_limits);
        let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
        [(); 2].map(|()| at_once(adapter.request_device(&descriptor)).unwrap())
    }
}

/// What a future gives that is ready.
fn at_once<F: Future>(future: F) -> F::Output {
    let mut context = std::task::Context::from_waker(std::task::Waker::noop());
    match std::pin::pin!(future).poll(&mut context) {
        std::task::Poll::Ready(output) => output,
        std::task::Poll::Pending => panic!("outside browsers wgpu's futures are ready"),
    }
}

pub const USAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
    .union(wgpu::BufferUsages::VERTEX)
    .union(wgpu::BufferUsages::COPY_SRC)
    .union(wgpu::BufferUsages::COPY_DST);

/// A buffer full of poison.
pub fn buffer(crumple: &Device, size: u64) -> wgpu::Buffer {
    let descriptor = wgpu::BufferDescriptor { label: None, size, usage: USAGE, mapped_at_creation: false };
    let buffer = crumple.device().create_buffer(&descriptor);
    crumple.queue().write_buffer(&buffer, 0, &POISON.to_le_bytes().repeat(size as usize / 4));
    buffer
}

/// All that a buffer holds.
pub fn read(crumple: &mut Device, buffer: &wgpu::Buffer) -> Vec<u32> {
    let mut bytes = vec![0; buffer.size() as usize];
    crumple.read(buffer, 0, &mut bytes).unwrap();
    bytes.chunks_exact(4).map(|w| u32::from_le_bytes(w.try_into().unwrap())).collect()
}
