//! Tests of the glTF reader: `cad` the two sample exports, `features` small assets for one feature each, `hostile`
//! broken ones, `motion` what moves.

mod cad;
mod compressed;
mod features;
mod hostile;
mod lights;
mod motion;
mod variants;
