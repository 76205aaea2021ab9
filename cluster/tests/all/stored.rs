//! As much of an object store as reading needs, so that a test can hold it up: it tells when it was
//! asked, and answers or never does.

use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::thread;

/// The settings of an executor whose object store is at an address.
pub(crate) fn settings(endpoint: &str) -> [(&str, &str); 5] {
    [
        ("AWS_ENDPOINT", endpoint),
        ("AWS_ALLOW_HTTP", "true"),
        ("AWS_REGION", "us-east-1"),
        ("AWS_ACCESS_KEY_ID", "tester"),
        ("AWS_SECRET_ACCESS_KEY", "secret-of-tests"),
    ]
}

/// The bucket of [`settings`] and the prefix in it.
pub(crate) const URL: &str = "s3://bucket/data";

/// A store that has the files of a folder; where it is.
pub(crate) fn store(root: &Path) -> String {
    store_without(root, None)
}

/// A store that has the files of a folder, and is silent if it is asked for this one; where it is.
pub(crate) fn store_without(root: &Path, missing: Option<PathBuf>) -> String {
    let (root, listener) = (root.to_owned(), TcpListener::bind("127.0.0.1:0").unwrap());
    let endpoint = format!("http://{}", listener.local_addr().unwrap());
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (root, missing) = (root.clone(), missing.clone());
            thread::spawn(move || serve(&stream, &root, missing.as_deref()));
        }
    });
    endpoint
}

/// A store that takes requests and never answers; where it is, and what tells of each request.
pub(crate) fn silent_store() -> (String, Receiver<TcpStream>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("http://{}", listener.local_addr().unwrap());
    let (tell, asked) = mpsc::channel();
    // A connection stays open as long as the test has its end.
    thread::spawn(move || listener.incoming().flatten().try_for_each(|stream| tell.send(stream)));
    (endpoint, asked)
}

/// Answers the requests of one connection.
fn serve(stream: &TcpStream, root: &Path, missing: Option<&Path>) {
    let mut lines = BufReader::new(stream).lines().map_while(Result::ok);
    while let Some(request) = lines.next() {
        while lines.next().is_some_and(|line| !line.is_empty()) {}
        let path = request.split(' ').nth(1).unwrap_or_default().replace("%3D", "=");
        let path: Option<PathBuf> = path.strip_prefix("/bucket/data/").map(|path| root.join(path));
        if path.is_some() && path.as_deref() == missing {
            // Until the other side hangs up.
            lines.by_ref().for_each(drop);
            return;
        }
        let (head, body) = match path.and_then(|path| fs::read(path).ok()) {
            Some(body) => ("200 OK", body),
            None => ("404 Not Found", b"there is none".to_vec()),
        };
        let head = format!(
            "HTTP/1.1 {head}\r\nContent-Length: {}\r\nETag: \"a\"\r\nLast-Modified: Mon, 05 Jan 2026 00:00:00 GMT\r\n\r\n",
            body.len()
        );
        let mut to = stream;
        if to.write_all(&[head.as_bytes(), &body].concat()).is_err() {
            return;
        }
    }
}
