//! `hysteron link` as a user meets it, with a bench on a socket.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use hysteron_host::dataset::{Dataset, Role};
use hysteron_host::link::settings::to_toml;
use hysteron_host::pil::{Hardware, Listener, serve};

use crate::support::bench;

/// Calls `work` with the port of a bench that is served meanwhile.
fn with_bench(work: impl FnOnce(&str)) {
    let listener = Listener::bind("tcp:127.0.0.1:0").unwrap();
    let port = listener.name();
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        // The bench is made where it runs: it need not be able to move there.
        scope.spawn(|| {
            serve(&listener, &mut bench(), &mut |_| {
                ended.load(Ordering::Relaxed)
            })
            .unwrap();
        });
        struct End<'a>(&'a AtomicBool);
        impl Drop for End<'_> {
            fn drop(&mut self) {
                self.0.store(true, Ordering::Relaxed);
            }
        }
        let _end = End(&ended);
        work(&port);
    });
}

fn link(port: &str, folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hysteron"));
    command
        .args(["link", "--port", port])
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

fn told(output: &Output) -> (String, String) {
    (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    )
}

fn done(port: &str, folder: &Path, arguments: &[&str]) -> String {
    let output = link(port, folder, arguments).output().unwrap();
    let (said, error) = told(&output);
    assert!(output.status.success(), "{arguments:?}: {error}");
    said
}

fn refused(port: &str, folder: &Path, arguments: &[&str]) -> String {
    let output = link(port, folder, arguments).output().unwrap();
    let (_, error) = told(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(error.starts_with("error: "), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    error
}

fn set_up(port: &str, folder: &Path) {
    let settings = to_toml(&Hardware::paper_j().unwrap().settings).unwrap();
    fs::write(folder.join("bench.toml"), settings).unwrap();
    done(port, folder, &["settings", "--set", "bench.toml"]);
}

#[test]
fn a_session_from_first_contact_to_a_compensated_scan() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    with_bench(|port| {
        let said = done(port, folder, &["info"]);
        assert!(said.contains("room for        16 plays") && said.contains("model           none"));
        set_up(port, folder);
        let text = fs::read_to_string(folder.join("bench.toml")).unwrap();
        assert_eq!(done(port, folder, &["settings"]), text);
        assert!(said.contains("saved           nothing"));
        assert!(done(port, folder, &["save"]).contains("after a reset"));
        let said = done(port, folder, &["info"]);
        assert!(said.contains("saved           what is in force"), "{said}");

        for (role, hz) in [("fit", "20"), ("select", "50")] {
            let record = [
                "record",
                "--out",
                "set",
                "--excitation",
                "sine",
                "--amplitude",
                "30",
                "--frequency",
                hz,
                "--seconds",
                "0.1",
                "--role",
                role,
            ];
            done(port, folder, &record);
        }
        let dataset = Dataset::load(folder.join("set")).unwrap();
        let roles: Vec<_> = dataset.records.iter().map(|record| record.role).collect();
        assert_eq!(roles, [Role::Fit, Role::Select]);
        assert_eq!(dataset.records[0].drive_v.len(), 1_000);
        assert!(dataset.records[0].start_s + 0.1 < dataset.records[1].start_s);

        assert!(done(port, folder, &["upload", "p753"]).contains("3 plays"));
        let mut reference = "time_s,reference_um\n".to_owned();
        for k in 0..1_500 {
            let t = f64::from(k) * 1e-4;
            let um = 20.0 * (std::f64::consts::TAU * 20.0 * t).sin();
            reference.push_str(&format!("{t},{um}\n"));
        }
        fs::write(folder.join("scan.csv"), reference).unwrap();
        let stream = ["stream", "scan.csv", "--record", "out.csv", "--stop"];
        let said = done(port, folder, &stream);
        assert!(
            said.contains("error: largest") && said.contains("1500 samples"),
            "{said}"
        );
        let out = fs::read_to_string(folder.join("out.csv")).unwrap();
        assert!(out.starts_with("time_s,reference_um,drive_v,displacement_um\n"));
        assert_eq!(out.lines().count(), 1_501);

        let said = done(
            port,
            folder,
            &["watch", "--json", "--count", "3", "--every", "0.05"],
        );
        let times: Vec<f64> = said
            .lines()
            .map(|line| {
                let line: serde_json::Value = serde_json::from_str(line).unwrap();
                line["time_s"].as_f64().unwrap()
            })
            .collect();
        assert!(
            times.len() == 3 && times.is_sorted() && times[2] - times[0] < 1.0,
            "{times:?}"
        );

        let start = ["start", "--direct", "--amplitude", "5", "--frequency", "20"];
        done(port, folder, &start);
        assert!(refused(port, folder, &start).contains("state of the output"));
        assert!(refused(port, folder, &["settings", "--set", "bench.toml"]).contains("at rest"));
        done(port, folder, &["hold"]);
        done(port, folder, &["stop"]);
        done(port, folder, &["clear"]);
    });
}

#[test]
fn what_goes_wrong_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert!(refused("tcp:127.0.0.1:1", folder, &["info"]).contains("start the other end"));
    assert!(refused("no-such-device", folder, &["info"]).contains("serial device"));
    #[cfg(unix)]
    assert!(refused("unix:no-such-socket", folder, &["info"]).contains("start the other end"));
    with_bench(|port| {
        set_up(port, folder);
        fs::write(
            folder.join("slow.csv"),
            "time_s,reference_um\n0,0\n0.001,0\n",
        )
        .unwrap();
        assert!(refused(port, folder, &["stream", "slow.csv"]).contains("resample"));
        let too_far = [
            "record",
            "--out",
            "set",
            "--excitation",
            "triangle",
            "--amplitude",
            "60",
        ];
        assert!(refused(port, folder, &too_far).contains("-60 V to 60 V"));
        assert!(refused(port, folder, &["upload", "none.toml"]).contains("p753"));
        assert!(!folder.join("set").exists());
    });
}

#[cfg(unix)]
fn wait_for_end(child: &mut Child, limit: Duration) -> Option<i32> {
    let begun = Instant::now();
    while begun.elapsed() < limit {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    panic!("the program does not end");
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_the_stage_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    with_bench(|port| {
        set_up(port, folder);
        let record = [
            "record",
            "--out",
            "set",
            "--excitation",
            "sine",
            "--amplitude",
            "30",
            "--seconds",
            "60",
        ];
        let mut child = link(port, folder, &record).spawn().unwrap();
        // Until it has begun: the socket serves one host at a time.
        thread::sleep(Duration::from_millis(700));
        assert!(child.try_wait().unwrap().is_none());
        let sent = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status()
            .unwrap();
        assert!(sent.success());
        assert_eq!(wait_for_end(&mut child, Duration::from_secs(10)), Some(130));
        assert!(!folder.join("set").exists());
        let said = done(
            port,
            folder,
            &["watch", "--json", "--count", "2", "--every", "0.3"],
        );
        let last: serde_json::Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
        assert_eq!(last["state"], "Off");
        assert_eq!(last["driver_enabled"], false);
        assert!(last["played"].as_u64().unwrap() > 0, "it had begun: {last}");
    });
}
