//! Tests of the glTF reader: `cad` the two sample exports, `features` small assets for one feature each, `hostile`
//! broken ones.

mod cad;
mod compressed;
mod features;
mod hostile;
mod lights;
