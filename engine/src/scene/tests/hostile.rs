//! Broken and hostile files end in problems, quickly, and never in a panic.

use glam::UVec2;

use super::*;
use crate::frame::TraceSettings;
use crate::trace::ActiveTracer;
use crate::trace::cpu::CpuTracer;

/// Scene files with pieces moved, doubled, cut out and replaced by chance.
fn mutated(text: &str, chance: &mut Chance) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..1 + chance.below(6) {
        let at = chance.below(bytes.len().max(1));
        let end = (at + chance.below(40)).min(bytes.len());
        match chance.below(6) {
            0 => drop(bytes.drain(at.min(end)..end)),
            1 => {
                let piece = bytes[at.min(end)..end].to_vec();
                let to = chance.below(bytes.len().max(1));
                bytes.splice(to..to, piece);
            }
            2 => {
                let marks = b"()[]{}:,\"'/*#!-+.e0 9aN\\\n\xc3\xff";
                bytes.insert(at.min(bytes.len()), marks[chance.below(marks.len())]);
            }
            3 if at < bytes.len() => bytes[at] = chance.next() as u8,
            4 => bytes.truncate(at),
            _ => {
                let words = [
                    "1e999",
                    "-0",
                    "NaN",
                    "99999999999999999999",
                    "None",
                    "Some(",
                    "\"\"",
                    "radius",
                    "((((",
                ];
                let word = words[chance.below(words.len())];
                bytes.splice(at.min(end)..end, word.bytes());
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A scene file with a few numbers of any size in place of its own.
fn with_wild_numbers(text: &str, chance: &mut Chance) -> String {
    let mut text = text.to_owned();
    for _ in 0..1 + chance.below(4) {
        let starts: Vec<usize> = text
            .match_indices([' ', '('])
            .map(|(at, _)| at + 1)
            .filter(|&at| text[at..].starts_with(|c: char| c.is_ascii_digit() || c == '-'))
            .collect();
        if starts.is_empty() {
            break;
        }
        let start = starts[chance.below(starts.len())];
        let length = text[start..].find([',', ')', ' ', '\n']).unwrap_or(0);
        let wild = [
            "0", "-3", "1e-40", "1e8", "1e18", "1e40", "-1e200", "1e-300",
        ];
        text.replace_range(start..start + length, wild[chance.below(wild.len())]);
    }
    text
}

#[test]
fn mutated_scenes_never_panic() {
    let folder = assets();
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "ron"))
        .collect();
    files.sort();
    assert!(!files.is_empty(), "no scene in {}", folder.display());
    let mut chance = Chance(42);
    let mut engine = Engine::new();
    engine.world.resource_mut::<TraceSettings>().size = UVec2::new(4, 3);
    engine.world.resource_mut::<ActiveTracer>().0 = Some(Box::new(CpuTracer::new()));
    let mut loaded = 0;
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        for round in 0..200 {
            let broken = match round % 2 {
                0 => mutated(&text, &mut chance),
                _ => with_wild_numbers(&text, &mut chance),
            };
            // The folder is another, so that meshes are not read thousands of times.
            let path = Path::new("nowhere/f.ron");
            if load_text(&mut engine.world, &broken, path).is_ok() {
                engine.frame();
                save(&mut engine.world);
                loaded += 1;
            }
        }
    }
    assert!(loaded > 50, "only {loaded} of the broken scenes loaded");
}

#[test]
fn deep_and_wide_files_end() {
    let path = Path::new("f.ron");
    let deep = format!("(version: 1, entities: [{}", "(children: [".repeat(100_000));
    assert!(!check_text(&deep, path).problems.0.is_empty());
    let wide = format!(
        "(version: 1, entities: [{}])",
        "(sphere: (radius: 0)),".repeat(50_000)
    );
    assert!(check_text(&wide, path).problems.0.len() <= 1000);
    let open = "(".repeat(1_000_000);
    assert!(!check_text(&open, path).problems.0.is_empty());
    let strange: String = ('\u{0}'..'\u{ffff}').collect();
    assert!(!check_text(&strange, path).problems.0.is_empty());
}

#[test]
fn entities_may_nest_as_deep_as_brackets_allow() {
    let depth = 90;
    let text = format!(
        "(version: 1, entities: [{}(){}])",
        "(children: [".repeat(depth),
        "])".repeat(depth)
    );
    let mut world = World::new();
    let report = load_text(&mut world, &text, Path::new("f.ron")).unwrap();
    assert_eq!(report.summary.entities, depth + 1);
}
