//! The registry of rules that look at an asset without tracing it. A new rule is a file and two lines here; those that
//! trace stand in `validate/rules`.

mod eb0001;
mod eb0002;
mod eb0003;
mod eb0004;
mod eb0005;
mod eb0006;
mod eb0007;
mod eb0008;
mod eb0101;
mod eb0102;
pub mod eb0103;
mod eb0106;
mod eb0107;
mod eb0108;
mod eb0109;
mod eb0110;
mod eb0111;
mod eb0112;
mod eb0113;
mod eb0114;
mod eb0115;
mod eb0116;
mod eb0201;
mod eb0202;
mod eb0203;
mod eb0204;
mod eb0205;
mod eb0206;
mod eb0207;
mod eb0208;
mod eb0209;
mod eb0210;
mod eb0211;
mod eb0212;
mod eb0301;
mod eb0302;
mod eb0303;
mod eb0304;
mod eb0305;
mod eb0306;
mod eb0307;
mod eb0308;
mod eb0309;
mod eb0310;
mod eb0311;
mod eb0401;
mod eb0402;
mod eb0403;
mod eb0404;
mod eb0501;
mod eb0502;
mod eb0503;
mod eb0601;
mod eb0602;
mod eb0603;
mod eb0604;
mod eb0605;
mod eb0606;
mod eb0607;
mod eb0608;

use super::rule::Rule;

/// By code.
pub const RULES: &[&Rule] = &[
    &eb0001::RULE,
    &eb0002::RULE,
    &eb0003::RULE,
    &eb0004::RULE,
    &eb0005::RULE,
    &eb0006::RULE,
    &eb0007::RULE,
    &eb0008::RULE,
    &eb0101::RULE,
    &eb0102::RULE,
    &eb0103::RULE,
    &eb0106::RULE,
    &eb0107::RULE,
    &eb0108::RULE,
    &eb0109::RULE,
    &eb0110::RULE,
    &eb0111::RULE,
    &eb0112::RULE,
    &eb0113::RULE,
    &eb0114::RULE,
    &eb0115::RULE,
    &eb0116::RULE,
    &eb0201::RULE,
    &eb0202::RULE,
    &eb0203::RULE,
    &eb0204::RULE,
    &eb0205::RULE,
    &eb0206::RULE,
    &eb0207::RULE,
    &eb0208::RULE,
    &eb0209::RULE,
    &eb0210::RULE,
    &eb0211::RULE,
    &eb0212::RULE,
    &eb0301::RULE,
    &eb0302::RULE,
    &eb0303::RULE,
    &eb0304::RULE,
    &eb0305::RULE,
    &eb0306::RULE,
    &eb0307::RULE,
    &eb0308::RULE,
    &eb0309::RULE,
    &eb0310::RULE,
    &eb0311::RULE,
    &eb0401::RULE,
    &eb0402::RULE,
    &eb0403::RULE,
    &eb0404::RULE,
    &eb0501::RULE,
    &eb0502::RULE,
    &eb0503::RULE,
    &eb0601::RULE,
    &eb0602::RULE,
    &eb0603::RULE,
    &eb0604::RULE,
    &eb0605::RULE,
    &eb0606::RULE,
    &eb0607::RULE,
    &eb0608::RULE,
];
