// The tests of both programs, `main.rs` and `long.rs`.

mod common;

// What is said of the project.
mod docs;
mod floors;
mod schemas;

// Closed forms and tables that others made.
mod oracle_dispersion;
mod oracle_eye;
mod oracle_fresnel;
mod oracle_lens;
mod oracle_radiometry;
mod oracle_slabs;
mod oracle_thinfilm;

// Light.
mod displays;
mod doublet;
mod generated;
mod grating_tables;
mod gratings;
mod hud;
mod klems;
mod lights;
mod looks;
mod lost_light;
mod manifold;
mod modes;
mod peers;
mod physics;
mod polarisers;
mod samples;
mod stress;
mod tolerance;
mod witness;

// Layers.
mod adaptive;
mod aov;
mod crop;
mod cryptomatte;
mod layer_errors;
mod mix;
mod several_slides;

// Files in and out.
mod author;
mod examples;
mod hostile;
mod prescriptions;
mod ray_files;
mod usd_out;
mod usd_survive;

// Commands.
mod completions;
mod emission_textures;
mod found;
mod inspect_init;
mod paths;
mod report;
mod scan;
mod scan_guides;
mod scan_pictures;
mod sensor;
mod sequence;
mod shards;
mod signals;
mod sky_borders;
mod slanted_edge;
mod validate;
mod wedge;
