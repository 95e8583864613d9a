//! The page in QuickJS, on the few parts of a browser that `dom.js` has: in every run of the tests, with no browser at hand.

use flate2::read::ZlibDecoder;
use rquickjs::context::EvalOptions;
use rquickjs::function::Func;
use rquickjs::{CatchResultExt, Context, Ctx, Exception, Function, Object, Runtime};
use std::io::Read;
use std::time::{Duration, Instant};

const DOM: &str = include_str!("dom.js");
/// The page of the test needs some MB and far less than a second.
const MOST_BYTES: usize = 256 << 20;
const LONGEST: Duration = Duration::from_secs(60);

/// The text that the page writes at its end.
/// Errors: what a script threw, what the page shows as its fault, or that it did not get to its end.
pub fn selftest(page: &str) -> Result<String, String> {
    let runtime = Runtime::new().map_err(|error| error.to_string())?;
    runtime.set_memory_limit(MOST_BYTES);
    let start = Instant::now();
    runtime.set_interrupt_handler(Some(Box::new(move || start.elapsed() > LONGEST)));
    let context = Context::full(&runtime).map_err(|error| error.to_string())?;
    context.with(|ctx| run(&ctx, page).catch(&ctx).map_err(|error| error.to_string()))?
}

fn run(ctx: &Ctx, page: &str) -> rquickjs::Result<Result<String, String>> {
    ctx.globals().set("inflate", Func::from(inflate))?;
    let dom: Object = eval(ctx, DOM)?;
    let scripts: Vec<String> = dom.get::<_, Function>("open")?.call((page,))?;
    for script in scripts {
        eval::<()>(ctx, &script)?;
    }
    let turn: Function = dom.get("turn")?;
    loop {
        while ctx.execute_pending_job() {}
        if !turn.call::<_, bool>(())? {
            break;
        }
    }
    let said: Function = dom.get("said")?;
    if let Some(fault) = said.call::<_, Option<String>>(("fault",))? {
        return Ok(Err(fault));
    }
    let end: Option<String> = said.call(("selftest",))?;
    Ok(end.ok_or_else(|| "the page did not get to its end".to_owned()))
}

/// A script of a page: it says itself whether it is strict, and shares its names with the next.
fn eval<'js, V: rquickjs::FromJs<'js>>(ctx: &Ctx<'js>, script: &str) -> rquickjs::Result<V> {
    let mut options = EvalOptions::default();
    (options.global, options.strict) = (true, false);
    ctx.eval_with_options(script, options)
}

fn inflate(ctx: Ctx, bytes: Vec<u8>) -> rquickjs::Result<Vec<u8>> {
    let mut plain = Vec::new();
    match ZlibDecoder::new(&bytes[..]).read_to_end(&mut plain) {
        Ok(_) => Ok(plain),
        Err(error) => Err(Exception::throw_type(&ctx, &format!("no zlib stream: {error}"))),
    }
}
