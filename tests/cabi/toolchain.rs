//! The compilers of this machine and the library under test.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use libtest_mimic::Failed;

/// Runs a command; its output, or what it said when it failed.
pub(super) fn run(command: &mut Command) -> Result<String, Failed> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        return Ok(text.into_owned());
    }
    Err(format!("{command:?}: {}\n{text}", output.status).into())
}

pub(super) fn scratch() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cabi");
    std::fs::create_dir_all(&folder).expect("cargo's temporary folder can be written");
    folder
}

/// The library as cargo built it for this very run.
#[derive(Clone)]
pub(super) struct Library {
    /// Last arguments of the linker's command line.
    link: Vec<OsString>,
    /// What sets executables apart that are linked in different ways.
    suffix: &'static str,
}

impl Library {
    /// The shared library, in a folder where the linker and the loader find it by their names for it.
    pub(super) fn shared() -> Self {
        let file = shared_library_file();
        // A link of an earlier run may point to another profile's library.
        let _ = std::fs::remove_file(&file);
        let name = file.file_name().expect("it is a file").to_string_lossy();
        std::os::unix::fs::symlink(beside_this_test(&name), &file).expect("a link can be made");
        Self { link: vec!["-L".into(), scratch().into(), "-ldrr".into()], suffix: "" }
    }

    /// The static library, with what Rust's standard library needs of the system.
    pub(super) fn linked_statically() -> Self {
        let system: &[&str] = if cfg!(target_os = "linux") { &["-lpthread", "-ldl"] } else { &[] };
        let mut link: Vec<OsString> = vec![beside_this_test("libdrr.a").into()];
        link.extend(system.iter().map(Into::into));
        Self { link, suffix: "-static" }
    }

    /// For programs that need none.
    pub(super) fn none() -> Self {
        Self { link: Vec::new(), suffix: "" }
    }

    /// A library by the arguments that link it.
    pub(super) fn linked_by(link: Vec<OsString>, suffix: &'static str) -> Self {
        Self { link, suffix }
    }
}

/// Where [`Library::shared`] puts it.
pub(super) fn shared_library_file() -> PathBuf {
    scratch().join(if cfg!(target_vendor = "apple") { "libdrr.dylib" } else { "libdrr.so" })
}

/// Runs a program that was made here. Cargo's own loader path would find the library of an earlier build first.
pub(super) fn launch(executable: &Path) -> Command {
    let path = if cfg!(target_vendor = "apple") { "DYLD_LIBRARY_PATH" } else { "LD_LIBRARY_PATH" };
    let mut command = Command::new(executable);
    command.env(path, scratch()).env("ASAN_OPTIONS", "detect_leaks=1:allocator_may_return_null=1");
    command
}

/// Cargo puts the libraries of a test run beside the test's executable; the copies one folder up are of earlier builds.
fn beside_this_test(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("this test runs from a file");
    let path = test.with_file_name(name);
    assert!(path.is_file(), "{} is not there", path.display());
    path
}

/// A compiler and the options that make it one of the header's readers.
#[derive(Clone)]
pub(super) struct Compiler {
    name: String,
    options: Vec<String>,
    /// What sets this compiler's executables apart.
    label: String,
}

const STRICT: [&str; 3] = ["-Wall", "-Wextra", "-Werror"];
const SANITIZERS: [&str; 3] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"];

impl Compiler {
    /// The first of `names` that compiles a trivial program with `options` and, if it is to, runs it.
    fn find(label: &str, names: &[String], options: &[&str], runs: bool) -> Result<Self, String> {
        let options: Vec<_> = options.iter().map(ToString::to_string).collect();
        for name in names {
            let compiler = Self { name: name.clone(), options: options.clone(), label: label.to_owned() };
            if compiler.works(runs).is_ok() {
                return Ok(compiler);
            }
        }
        Err(format!("no {label} compiler: tried {}", names.join(", ")))
    }

    /// C of a standard.
    pub(super) fn c(standard: &str) -> Result<Self, String> {
        let standard_option = format!("-std={standard}");
        let options = [&["-x", "c", "-pedantic", "-D_POSIX_C_SOURCE=200809L", &standard_option], &STRICT[..]];
        Self::find(standard, &["cc", "gcc", "clang"].map(String::from), &options.concat(), true)
    }

    /// C++ of a standard.
    pub(super) fn cpp(standard: &str) -> Result<Self, String> {
        let standard_option = format!("-std={standard}");
        let options = [&["-x", "c++", "-pedantic", &standard_option], &STRICT[..]];
        Self::find(standard, &["c++", "g++", "clang++"].map(String::from), &options.concat(), true)
    }

    /// C++ with warnings of those who warn of everything.
    pub(super) fn cpp_wrapper(standard: &str) -> Result<Self, String> {
        let warnings = ["-Wconversion", "-Wsign-conversion", "-Wshadow"];
        let mut compiler = Self::cpp(standard)?;
        compiler.options.extend(warnings.map(String::from));
        Ok(compiler)
    }

    /// C++ with the address and undefined-behaviour sanitizers.
    pub(super) fn cpp_sanitized() -> Result<Self, String> {
        let options = [&["-x", "c++", "-std=c++17"], &STRICT[..], &SANITIZERS[..]];
        Self::find("sanitizing C++", &["clang++", "g++", "c++"].map(String::from), &options.concat(), true)
    }

    /// Objective-C.
    pub(super) fn objective_c() -> Result<Self, String> {
        let options = [&["-x", "objective-c", "-std=gnu11"], &STRICT[..]];
        Self::find("objective-c", &["clang", "cc", "gcc"].map(String::from), &options.concat(), true)
    }

    /// Objective-C with modules, which are Clang's.
    pub(super) fn modules() -> Result<Self, String> {
        let cache = format!("-fmodules-cache-path={}", scratch().join("modules").display());
        let options = [&["-x", "objective-c", "-std=gnu11", "-fmodules", &cache], &STRICT[..]];
        Self::find("modules", &["clang".to_owned()], &options.concat(), true)
    }

    /// C with the address and undefined-behaviour sanitizers.
    pub(super) fn sanitized() -> Result<Self, String> {
        let options = [&["-x", "c", "-std=c11"], &STRICT[..], &SANITIZERS[..]];
        Self::find("sanitizing", &["clang", "gcc", "cc"].map(String::from), &options.concat(), true)
    }

    /// C with the thread sanitizer, by Clang; its run-time is to come with the library.
    pub(super) fn thread_sanitized() -> Result<Self, String> {
        let sanitizer = ["-fsanitize=thread", "-fno-sanitize-link-runtime", "-g"];
        let options = [&["-x", "c", "-std=c11"], &STRICT[..], &sanitizer[..]];
        Self::find("thread-sanitizing", &["clang".to_owned()], &options.concat(), false)
    }

    /// Clang reading the header and the kernel text as Metal's compiler would, with stand-ins for Metal's own headers and no
    /// others. What a kernel leaves unused is none of an embedding program's concern.
    pub(super) fn metal_stand_in() -> Result<Self, String> {
        let headers = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/support/msl");
        let metal = ["-x", "c++", "-std=c++14", "-nostdinc", "-nostdinc++", "-isystem", headers];
        let unused = ["-Wno-unused", "-Wno-unused-parameter", "-Wno-unneeded-internal-declaration"];
        // [[buffer(0)]], and Metal's pragmas.
        let unknown = ["-Wno-unknown-attributes", "-Wno-unknown-pragmas"];
        let options = [&metal[..], &["-D__METAL_VERSION__=300"], &STRICT[..], &unused, &unknown];
        Self::find("clang++", &["clang++".to_owned()], &options.concat(), false)
    }

    /// Compiles without making anything.
    pub(super) fn check(&self, source: &Path) -> Result<(), Failed> {
        run(self.command().arg("-fsyntax-only").arg(source)).map(|_| ())
    }

    /// Compiles and links a program.
    pub(super) fn executable(&self, source: &Path, library: &Library) -> Result<PathBuf, Failed> {
        let name = source.file_stem().unwrap_or_default().to_string_lossy();
        let executable = scratch().join(format!("{name}-{}{}", self.label, library.suffix));
        let mut command = self.command();
        // What follows the source is not source.
        command.arg(source).args(["-x", "none", "-o"]).arg(&executable).args(&library.link).arg("-lm");
        run(command.arg("-pthread")).map(|_| executable)
    }

    /// Compiles a shared library that needs no other.
    pub(super) fn shared_library(&self, source: &Path, library: &Path) -> Result<(), Failed> {
        // Beside its place first: another test may be loading the one that is there.
        let made = library.with_extension(format!("{:?}", std::thread::current().id()));
        let mut command = self.command();
        command.args(["-D_GNU_SOURCE", "-O1", "-shared", "-fPIC"]).arg(source).arg("-o").arg(&made);
        run(command.arg("-pthread"))?;
        Ok(std::fs::rename(made, library)?)
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.name);
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        command
            .args(&self.options)
            .arg("-I")
            .arg(root.join("include"))
            .arg("-I")
            .arg(root.join("cabi-tests"));
        command
    }

    fn works(&self, runs: bool) -> Result<(), Failed> {
        let source = scratch().join("trivial.c");
        std::fs::write(&source, "int main(void) { return 0; }\n")?;
        if !runs {
            return self.check(&source);
        }
        let executable = self.executable(&source, &Library::none())?;
        run(&mut launch(&executable)).map(|_| ())
    }
}
