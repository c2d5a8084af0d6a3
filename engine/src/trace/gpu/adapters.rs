//! Graphics adapters: which there are, in what order, and which one a choice means.

use crate::trace::TraceError;

/// Which adapter to open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AdapterChoice {
    /// A real GPU; a software adapter counts as none.
    Hardware,
    /// A real GPU if there is one, else a software adapter.
    Any,
    /// By number, or by a part of its name in any case, in the order of [`super::Gpu::adapters`].
    Named(String),
}

/// All of them: discrete, integrated, virtual, unknown, software; within a kind as the drivers list them.
pub fn list(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters
}

fn rank(info: &wgpu::AdapterInfo) -> u32 {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// Whether it is a program on the processor.
pub fn is_software(info: &wgpu::AdapterInfo) -> bool {
    info.device_type == wgpu::DeviceType::Cpu
}

/// Name, API and driver.
pub fn describe(info: &wgpu::AdapterInfo) -> String {
    let driver = if info.driver_info.is_empty() {
        &info.driver
    } else {
        &info.driver_info
    };
    format!("{}, {:?}, driver {driver}", info.name, info.backend)
}

/// Indices of the adapters that fit a choice, best first.
///
/// # Errors
/// [`TraceError::NoDevice`] with what there is.
pub fn choose(
    infos: &[wgpu::AdapterInfo],
    choice: &AdapterChoice,
) -> Result<Vec<usize>, TraceError> {
    let fits: Vec<usize> = match choice {
        AdapterChoice::Any => (0..infos.len()).collect(),
        AdapterChoice::Hardware => (0..infos.len())
            .filter(|&i| !is_software(&infos[i]))
            .collect(),
        AdapterChoice::Named(name) => match name.parse::<usize>() {
            Ok(number) => (0..infos.len()).filter(|&i| i == number).collect(),
            Err(_) => {
                let name = name.to_lowercase();
                (0..infos.len())
                    .filter(|&i| infos[i].name.to_lowercase().contains(&name))
                    .collect()
            }
        },
    };
    if !fits.is_empty() {
        return Ok(fits);
    }
    let seen = if infos.is_empty() {
        "no adapter at all (is a Vulkan, Metal or DirectX 12 driver installed?)".to_owned()
    } else {
        let names: Vec<_> = infos
            .iter()
            .enumerate()
            .map(|(i, info)| format!("{i}: {}", describe(info)))
            .collect();
        names.join("; ")
    };
    Err(TraceError::NoDevice(match choice {
        AdapterChoice::Named(name) => format!("no GPU adapter is called \"{name}\"; found {seen}"),
        AdapterChoice::Hardware => format!("no hardware GPU; found {seen}"),
        AdapterChoice::Any => format!("no GPU; found {seen}"),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(name: &str, device_type: wgpu::DeviceType) -> wgpu::AdapterInfo {
        wgpu::AdapterInfo {
            name: name.to_owned(),
            ..wgpu::AdapterInfo::new(device_type, wgpu::Backend::Vulkan)
        }
    }

    fn two() -> [wgpu::AdapterInfo; 2] {
        [
            info("NVIDIA H200", wgpu::DeviceType::DiscreteGpu),
            info("llvmpipe", wgpu::DeviceType::Cpu),
        ]
    }

    #[test]
    fn software_is_no_hardware() {
        assert_eq!(choose(&two(), &AdapterChoice::Hardware), Ok(vec![0]));
        assert_eq!(choose(&two(), &AdapterChoice::Any), Ok(vec![0, 1]));
        let alone = choose(&two()[1..], &AdapterChoice::Hardware);
        assert!(matches!(alone, Err(TraceError::NoDevice(why)) if why.contains("llvmpipe")));
    }

    #[test]
    fn adapters_go_by_number_or_part_of_the_name() {
        let named = |name: &str| choose(&two(), &AdapterChoice::Named(name.to_owned()));
        assert_eq!(named("1"), Ok(vec![1]));
        assert_eq!(named("h200"), Ok(vec![0]));
        assert!(matches!(named("2"), Err(TraceError::NoDevice(_))));
        assert!(
            matches!(named("radeon"), Err(TraceError::NoDevice(why)) if why.contains("radeon"))
        );
    }
}
