use bevy_ecs::prelude::*;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::*;
use crate::frame::{FrameScene, TraceSettings};
use crate::input::{Input, MouseButton};
use crate::profile::{Change, EntityCost, EntityCosts, Pass, Span};
use crate::trace::Upload;
use crate::world::SceneId;

fn frame(id: u64, slow: f64) -> Frame {
    let span = |name: &str, start_micros, micros, depth| Span {
        name: name.into(),
        start_micros,
        micros,
        depth,
    };
    Frame {
        id,
        start_micros: id as f64 * 16e3,
        micros: 8000.0 + slow,
        spans: vec![
            span("extract", 0.0, 3000.0, 0),
            span("apply_rules", 3000.0, 2000.0 + slow, 0),
            span("rule 7", 3000.0, 1500.0 + slow, 1),
        ],
        passes: vec![Pass {
            name: "whitted".into(),
            start_micros: 5000.0,
            micros: 2500.0,
            error_micros: 40.0,
        }],
        ..Frame::default()
    }
}

/// A panel over 60 frames, the 40th of which is slow.
fn harness() -> Harness<'static, World> {
    let mut world = World::new();
    world.init_resource::<Profile>();
    world.init_resource::<ProfilerView>();
    world.init_resource::<Notices>();
    world.init_resource::<ActiveTracer>();
    world.init_resource::<PixelView>();
    world.init_resource::<Ledger>();
    world.init_resource::<EntityCosts>();
    world.init_resource::<EditorState>();
    let mut frames = Frames::default();
    for id in 1..=60 {
        frames.push(frame(id, if id == 40 { 20e3 } else { 0.0 }));
    }
    world.insert_resource(frames);
    let mut harness = Harness::builder()
        .with_size(egui::vec2(1200.0, 700.0))
        .build_ui_state(
            |ui, world: &mut World| {
                mind_ledger(world, true);
                show(ui, world);
            },
            world,
        );
    harness.run_ok();
    harness
}

#[test]
fn a_slow_frame_is_found_in_the_list_looked_at_and_kept() {
    let mut harness = harness();
    harness.get_by_label("Slowest").click();
    harness.run_ok();
    assert!(
        harness
            .query_by_label("rule 7: 21.50, usually 1.50")
            .is_some()
    );
    harness.get_by_label("frame 40   28.00 ms").click();
    harness.run_ok();
    assert_eq!(
        harness.state().resource::<ProfilerView>().selected,
        Some(40)
    );
    let stopped = harness.state().resource::<Frames>().stopped();
    assert_eq!(stopped, Some(Stop::Asked), "it would be overwritten");
    harness.get_by_label("Record").click();
    harness.run_ok();
    assert_eq!(harness.state().resource::<ProfilerView>().selected, None);
    assert_eq!(harness.state().resource::<Frames>().stopped(), None);
}

#[test]
fn a_click_on_a_bar_looks_at_its_frame() {
    let mut harness = harness();
    let bars = harness.get_by_label("frame history").rect();
    // Four points a frame, the newest at the right.
    let at = bars.right_center() - egui::vec2(4.0 * 20.5, 0.0);
    harness.hover_at(at);
    for pressed in [true, false] {
        harness.event(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
    }
    harness.run_ok();
    assert_eq!(
        harness.state().resource::<ProfilerView>().selected,
        Some(40)
    );
}

#[test]
fn a_span_that_is_clicked_is_marked_and_the_wheel_zooms_about_the_pointer() {
    let mut harness = harness();
    let bars: Vec<_> = harness.get_all_by_label("apply_rules").collect();
    let at = bars[0].rect().center();
    bars[0].click();
    drop(bars);
    harness.run_ok();
    let view = harness.state().resource::<ProfilerView>();
    assert_eq!(view.marked.as_deref(), Some("apply_rules"));
    assert_eq!(view.shown, None);
    harness.hover_at(at);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        source: egui::MouseWheelSource::Wheel,
        delta: egui::vec2(0.0, 120.0),
        phase: egui::TouchPhase::Move,
        modifiers: egui::Modifiers::NONE,
    });
    harness.run_steps(12);
    let shown = harness.state().resource::<ProfilerView>().shown;
    let [from, to] = shown.expect("less than all");
    assert!(to - from < 7000.0, "{shown:?}");
    assert!(
        from < 4000.0 && to > 4000.0,
        "the pointer's time stays: {shown:?}"
    );
}

#[test]
fn uploads_name_what_changed_and_who_wrote_it() {
    let mut harness = harness();
    let ball = harness.state_mut().spawn(SceneId("ball".into())).id();
    harness.get_by_label("Uploads").click();
    harness.run_ok();
    assert!(
        harness.state().resource::<Ledger>().wanted,
        "only while it is shown"
    );
    let mut ledger = harness.state_mut().resource_mut::<Ledger>();
    ledger.uploads = vec![Upload {
        buffer: "instances",
        bytes: 1440,
    }];
    ledger.changes = vec![Change {
        component: "Transform".into(),
        system: Some("apply_orbits".into()),
        entities: vec![ball],
        count: 3,
        buffers: &["instances", "nodes"],
    }];
    harness.run_ok();
    assert!(harness.query_by_label("instances").is_some());
    assert!(harness.query_by_label("1 440 bytes").is_some());
    assert!(
        harness
            .query_by_label("Transform of 3, by apply_orbits")
            .is_some()
    );
    harness.get_by_label("ball").click();
    harness.run_ok();
    assert_eq!(
        harness.state().resource::<EditorState>().selection.all(),
        [ball]
    );
    harness.get_by_label("Costs").click();
    harness.run_ok();
    assert!(!harness.state().resource::<Ledger>().wanted);
}

#[test]
fn a_pixel_that_is_picked_is_explained() {
    let mut harness = harness();
    let world = harness.state_mut();
    world.init_resource::<Input>();
    world.init_resource::<FrameScene>();
    world.insert_resource(TraceSettings {
        size: glam::UVec2::new(120, 70),
        ..TraceSettings::default()
    });
    let click = |harness: &mut Harness<World>| {
        let mut input = harness.state_mut().resource_mut::<Input>();
        input.point_at(Some(glam::DVec2::new(605.0, 105.0)));
        input.button(MouseButton::Left, true);
        harness.step();
        let mut input = harness.state_mut().resource_mut::<Input>();
        input.button(MouseButton::Left, false);
        input.end_frame();
        harness.run_ok();
    };
    harness.get_by_label("Pixel").click();
    harness.run_ok();
    click(&mut harness);
    assert!(harness.query_by_label("Clear").is_none(), "nobody asked");
    harness.get_by_label("Pick a pixel").click();
    harness.run_ok();
    click(&mut harness);
    let words = "pixel 60,10: 1 ray, light 0.0000 0.0000 0.0000";
    assert!(harness.query_by_label(words).is_some());
    // A scene that is empty has no generation either.
    let row = "camera, sample 0: not followed: past the last generation";
    assert!(harness.query_by_label(row).is_some());
}

#[test]
fn what_things_cost_is_listed_the_dearest_first() {
    let mut harness = harness();
    let world = harness.state_mut();
    let [cheap, dear] = ["cheap", "dear"].map(|id| world.spawn(SceneId(id.into())).id());
    let cost = |share| EntityCost {
        share,
        ..EntityCost::default()
    };
    let costs = [(cheap, cost(0.1)), (dear, cost(0.9))].into();
    world.insert_resource(EntityCosts(costs));
    harness.get_by_label("Things").click();
    harness.run_ok();
    let places = ["dear", "cheap"].map(|name| harness.get_by_label(name).rect().min.y);
    assert!(places[0] < places[1], "{places:?}");
    harness.get_by_label("dear").click();
    harness.run_ok();
    let state = harness.state().resource::<EditorState>();
    assert_eq!(state.selection.lead(), Some(dear));
}

#[test]
fn a_spike_is_looked_at_by_itself() {
    let mut harness = harness();
    let mut frames = harness.state_mut().resource_mut::<Frames>();
    frames.set_spike_limit(Some(20.0));
    frames.push(frame(61, 15e3));
    harness.run_ok();
    assert_eq!(
        harness.state().resource::<ProfilerView>().selected,
        Some(61)
    );
    assert!(harness.query_by_label("stopped by frame 61").is_some());
}
