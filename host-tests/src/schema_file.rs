//! The text form of the JSON Schemas kept under `docs/`.

use schemars::Schema;

/// The schema as kept under `docs/`: indented, with a line feed at the end.
pub(crate) fn text(schema: &Schema) -> String {
    format!("{:#}\n", schema.as_value())
}
