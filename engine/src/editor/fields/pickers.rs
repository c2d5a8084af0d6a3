//! Choosing what a field refers to: an entity, a picture. A list with a search, because scenes have thousands.

use bevy_ecs::prelude::*;

use crate::editor::naming::{kind, label};
use crate::editor::theme;
use crate::world::{Material, SceneId, TextureId, Textures, Transform};

/// Entries that are listed at once; a search finds the others.
const MOST: usize = 60;

/// Room for the button beside a list, points.
const BUTTON: f32 = 64.0;

/// What a picker says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picked {
    /// The field is to name this entity.
    Entity(Entity),
    /// The entity that it names is to be selected.
    Jump(Entity),
}

/// A field that names an entity: which, a list to choose another from, a way there.
pub fn entity(
    ui: &mut egui::Ui,
    world: &World,
    salt: &str,
    (now, materials_only): (Entity, bool),
) -> Option<Picked> {
    let mut picked = None;
    let name = label(world, now);
    // Were the line any wider than the panel, the panel would grow with it from frame to frame.
    let width = (ui.available_width() - BUTTON).max(40.0);
    egui::ComboBox::from_id_salt(("entity", salt))
        .selected_text(name)
        .width(width)
        .truncate()
        .height(260.0)
        .show_ui(ui, |ui| {
            let text = search(ui, salt);
            let mut listed = 0;
            for (entity, name) in candidates(world, materials_only) {
                if !name.to_lowercase().contains(&text) {
                    continue;
                }
                listed += 1;
                if listed > MOST {
                    ui.label(theme::faint("and more: type a part of the name"));
                    break;
                }
                if ui.selectable_label(entity == now, name).clicked() {
                    picked = Some(Picked::Entity(entity));
                }
            }
        });
    if ui.small_button("Go").on_hover_text("Select it").clicked() {
        picked = Some(Picked::Jump(now));
    }
    picked
}

/// The field of a search at the head of a list; what is typed, in lower case.
fn search(ui: &mut egui::Ui, salt: &str) -> String {
    let id = ui.make_persistent_id(("search", salt));
    let mut text: String = ui.data_mut(|data| data.get_temp(id)).unwrap_or_default();
    let field = egui::TextEdit::singleline(&mut text).hint_text("Search");
    ui.add(field.desired_width(f32::INFINITY));
    ui.data_mut(|data| data.insert_temp(id, text.clone()));
    text.to_lowercase()
}

fn candidates(world: &World, materials_only: bool) -> Vec<(Entity, String)> {
    let mut found: Vec<(Entity, String)> = world
        .iter_entities()
        .filter(|entity| {
            entity.contains::<Material>()
                || (!materials_only
                    && (entity.contains::<Transform>() || entity.contains::<SceneId>()))
        })
        .map(|entity| {
            let name = label(world, entity.id());
            let name = if materials_only {
                name
            } else {
                format!("{name} \u{b7} {}", kind(entity))
            };
            (entity.id(), name)
        })
        .collect();
    found.sort_by(|a, b| a.1.cmp(&b.1));
    found
}

/// A field that names a picture: which, or none.
pub fn texture(
    ui: &mut egui::Ui,
    world: &World,
    salt: &str,
    now: Option<TextureId>,
) -> Option<Option<TextureId>> {
    let textures = world.get_resource::<Textures>()?;
    let name = |id: TextureId| {
        let path = textures.get(id).map(|texture| texture.path.clone());
        path.filter(|path| !path.is_empty())
            .unwrap_or_else(|| format!("picture {}", id.0))
    };
    let mut next = now;
    egui::ComboBox::from_id_salt(("picture", salt))
        .selected_text(now.map_or_else(|| "none".into(), name))
        .width(ui.available_width().max(60.0))
        .truncate()
        .show_ui(ui, |ui| {
            ui.selectable_value(&mut next, None, "none");
            let rows = 0..textures.rows().len() as u32;
            for id in rows.map(TextureId) {
                if textures.get(id).is_some() {
                    ui.selectable_value(&mut next, Some(id), name(id));
                }
            }
        });
    (next != now).then_some(next)
}
