//! Renders one template with minijinja; see minijinja.h.

mod bounds;

use std::ffi::{c_int, c_void};
use std::io;
use std::sync::{Arc, Mutex, Once};

use minijinja::{AutoEscape, Environment, Error, ErrorKind, UndefinedBehavior, Value};

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Text {
    data: *const u8,
    size: usize,
}

impl Text {
    fn of(text: &str) -> Text {
        Text { data: text.as_ptr(), size: text.len() }
    }

    /// Safety: the text that the caller passed must still be there.
    unsafe fn bytes<'a>(self) -> &'a [u8] {
        if self.size == 0 {
            return &[];
        }
        std::slice::from_raw_parts(self.data, self.size)
    }
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Job {
    name: Text,
    variables: Text,
    html: c_int,
    fuel: u64,
    output: u64,
    memory: u64,
    context: *mut c_void,
    load: extern "C" fn(*mut c_void, Text, *mut Text) -> c_int,
    write: extern "C" fn(*mut c_void, Text),
    fail: extern "C" fn(*mut c_void, Text, usize, Text),
}

// The caller waits while another thread uses its pointers.
unsafe impl Send for Job {}
unsafe impl Sync for Job {}

struct Failure {
    file: String,
    line: usize,
    message: String,
}

/// Safety: all pointers of the job are valid, as minijinja.h says.
#[no_mangle]
pub unsafe extern "C" fn minijinja_render(job: &Job) {
    // What all renderings share is made here: a thread must not stop while it holds the lock of that.
    static SHARED: Once = Once::new();
    SHARED.call_once(|| drop(Environment::new().render_named_str("a.html", "{{ 1 }}", ())));
    let copy = *job;
    let failed = |message: String| Failure { file: String::new(), line: 0, message };
    let rendered = match bounds::run(job.memory as usize, move || render(&copy)) {
        Ok(rendered) => rendered,
        Err(bounds::Stop::Memory) => Err(failed(format!("the template needs more than {} bytes of memory", job.memory))),
        Err(bounds::Stop::Stack) => Err(failed("a value is nested too deep".into())),
        Err(bounds::Stop::Panic(message)) => Err(failed(format!("minijinja failed: {message}"))),
    };
    if let Err(failure) = rendered {
        let file = if failure.file.is_empty() { job.name } else { Text::of(&failure.file) };
        (job.fail)(job.context, file, failure.line, Text::of(&failure.message));
    }
}

fn render(job: &Job) -> Result<(), Failure> {
    let job = *job;
    let not_utf8 = Arc::new(Mutex::new(None));
    let found = not_utf8.clone();
    let mut environment = Environment::new();
    environment.set_debug(true); // errors name what is undefined
    minijinja_contrib::add_to_environment(&mut environment);
    environment.remove_filter("pprint"); // not Jinja's: it prints Rust, in time that grows with the square of the depth
    environment.remove_global("debug");
    environment.set_unknown_method_callback(minijinja_contrib::pycompat::unknown_method_callback);
    environment.set_fuel(Some(job.fuel));
    if job.html != 0 {
        environment.set_undefined_behavior(UndefinedBehavior::SemiStrict);
    }
    environment.set_auto_escape_callback(move |_| if job.html != 0 { AutoEscape::Html } else { AutoEscape::None });
    environment.set_loader(move |name| {
        let job = &job;
        let mut text = Text::of("");
        if (job.load)(job.context, Text::of(name), &mut text) == 0 {
            return Ok(None);
        }
        let bytes = unsafe { text.bytes() };
        match std::str::from_utf8(bytes) {
            Ok(text) => Ok(Some(text.to_string())),
            Err(error) => {
                let line = 1 + bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
                *found.lock().unwrap() = Some((name.to_string(), line));
                Err(Error::from(ErrorKind::SyntaxError))
            }
        }
    });

    let text = |text: Text| std::str::from_utf8(unsafe { text.bytes() }).unwrap_or("\u{fffd}");
    let variables = variables(&environment, text(job.variables)).map_err(|error| Failure {
        file: String::new(),
        line: 0,
        message: format!("the variables cannot be read: {}", failure(&error, &job).message),
    })?;
    let template = environment.get_template(text(job.name));
    let output = Output { job: &job, room: job.output as usize };
    match template.and_then(|template| template.render_captured_to(variables, output).map(|_| ())) {
        Ok(()) => Ok(()),
        Err(_) if not_utf8.lock().unwrap().is_some() => {
            let (file, line) = not_utf8.lock().unwrap().take().unwrap();
            Err(Failure { file, line, message: "found bytes that are not UTF-8".into() })
        }
        Err(error) => Err(failure(&error, &job)),
    }
}

/// JSON is an expression of Jinja, except for the word null.
fn variables(environment: &Environment, json: &str) -> Result<Value, Error> {
    environment.compile_expression(json)?.eval(minijinja::context! { null => () })
}

/// Hands the text over.
struct Output<'a> {
    job: &'a Job,
    room: usize,
}

impl io::Write for Output<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        bounds::check_stack();
        if bytes.len() > self.room {
            return Err(io::ErrorKind::OutOfMemory.into());
        }
        self.room -= bytes.len();
        (self.job.write)(self.job.context, Text { data: bytes.as_ptr(), size: bytes.len() });
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The error at its innermost place: an error inside of an included template has that of the include around it.
fn failure(error: &Error, job: &Job) -> Failure {
    let mut inner = error;
    while let Some(source) = std::error::Error::source(inner).and_then(|source| source.downcast_ref::<Error>()) {
        inner = source;
    }
    let message = match (inner.kind(), inner.detail()) {
        (ErrorKind::OutOfFuel, _) => format!("the template takes more than {} steps", job.fuel),
        (ErrorKind::WriteFailure, _) => format!("the template makes more than {} bytes of text", job.output),
        (_, Some(detail)) => detail.to_string(),
        (kind, None) => kind.to_string(),
    };
    Failure { file: inner.name().unwrap_or_default().into(), line: inner.line().unwrap_or(0), message }
}
