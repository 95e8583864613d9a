//! What authors have said beside the format, as `extras`.

use eyebox_scene::user_property::UserProperty;
use serde_json::{Map, Value as Json};

/// The object `extras`, if there is something to say.
pub fn extras(user: &[UserProperty]) -> Option<Json> {
    let entries = user.iter().map(|property| (property.name.clone(), property.value.json()));
    (!user.is_empty()).then(|| Json::Object(entries.collect::<Map<_, _>>()))
}
