//! A server and its clients: whole states, changes, late ones, slow ones, rude ones.

use eyot_live::{
    Alga, Body, Client, Colony, Control, Ending, Gone, Hello, LayerInfo, Message, Mirror, Moment, Notice, Options,
    Order, Permission, Raster, Record, Scene, Server, SpeciesInfo, Status,
};
use std::collections::HashSet;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// No test waits for this long; it only ends those that would wait for ever.
const LONG: Duration = Duration::from_secs(60);

fn hello() -> Hello {
    let species = ["massive", "branching"].map(|name| SpeciesInfo { name: name.into(), ..SpeciesInfo::default() });
    let layer = LayerInfo { name: "height".into(), unit: "m".into(), range: [-9.0, 9.0], stagger: 0 };
    Hello {
        recipe: "Test".into(),
        size: [40, 30],
        every: 1,
        rays: true,
        species: species.into(),
        layers: vec![layer],
        columns: vec!["cover".into()],
        ..Hello::default()
    }
}

/// Individuals come, change and go, and a layer grows, as the step says.
fn scene(step: u64) -> Scene {
    let mix = |a: u64, b: u64| (a.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ b.wrapping_mul(0xbf58_476d_1ce4_e5b9)) >> 40;
    let alive = |id: u64| (id..id + 5 + mix(id, 1) % 9).contains(&step);
    let size = |id: u64| (step - id).min(4) as f32 * 0.1;
    let ids = || (step.saturating_sub(20)..=step).filter(|&id| alive(id));
    let colony = |id: u64| Colony {
        id: 2 * id,
        settled: id as i32 - 3,
        species: (id % 2) as u16,
        bleached: mix(id, step) % 5 == 0,
        x: id as f32,
        radius: size(id),
        rays: [size(id); 24],
        ..Colony::default()
    };
    let alga = |id: u64| Alga { id: 2 * id + 1, settled: id as i32, height: size(id), ..Alga::default() };
    let cell = |i: u64| if mix(i, step) % 50 == 0 { step as f32 } else { (i % 7) as f32 };
    Scene {
        moment: Moment { steps_done: step, census: vec![step as f64], ..Moment::default() },
        colonies: ids().map(colony).collect(),
        algae: ids().rev().map(alga).collect(),
        layers: vec![(step > 2).then(|| Raster { width: 40, values: (0..1200).map(cell).collect() })],
    }
}

/// What a client ought to know.
fn tidy(step: u64, number: u64) -> Scene {
    let mut s = scene(step);
    s.algae.reverse();
    s.moment.living = [s.colonies.len() as u32, s.algae.len() as u32];
    s.moment.number = number;
    s
}

fn server(options: Options) -> (Server, Receiver<Notice>) {
    let (notices, inbox) = channel();
    let notices = std::sync::Mutex::new(notices);
    let server = Server::bind(options, move |n| drop(notices.lock().unwrap().send(n))).unwrap();
    server.hello(hello());
    (server, inbox)
}

fn client(server: &Server) -> Client {
    let client = Client::connect(server.address()).unwrap();
    client.set_patience(Some(LONG)).unwrap();
    client
}

fn until(client: &mut Client, number: u64) {
    while client.follow().unwrap() != Some(number) {}
}

fn to_the_end(client: &mut Client) -> Gone {
    loop {
        if let Err(e) = client.follow() {
            return e;
        }
    }
}

/// Waits until somebody is in. Clients are numbered where the server lets them in, which may be after they think so.
fn joined(inbox: &Receiver<Notice>) {
    while !matches!(inbox.recv_timeout(LONG).unwrap(), Notice::Joined { .. }) {}
}

fn left(inbox: &Receiver<Notice>, number: u64) -> String {
    loop {
        if let Notice::Left { client, reason, .. } = inbox.recv_timeout(LONG).unwrap()
            && client == number
        {
            return reason;
        }
    }
}

#[test]
fn every_client_knows_exactly_the_state_at_every_moment() {
    let (server, _) = server(Options::default());
    let mut early = client(&server);
    server.publish(scene(0));
    until(&mut early, 0);
    let mut second = client(&server);
    until(&mut second, 0);
    for step in 1..60 {
        server.publish(scene(step));
        for c in [&mut early, &mut second] {
            until(c, step);
            assert_eq!(c.mirror().scene().unwrap(), tidy(step, step));
            assert_eq!(c.mirror().snapshots(), 1);
        }
    }
    let mut late = client(&server);
    until(&mut late, 59);
    assert_eq!(late.mirror().scene(), early.mirror().scene());
    // Back to another moment, as a run that was rewound.
    server.publish(scene(7));
    until(&mut late, 60);
    assert_eq!(late.mirror().scene().unwrap(), tidy(7, 60));
    server.end(Ending::Done, "that was all");
    let mut after = client(&server);
    while after.mirror().end().is_none() {
        after.follow().unwrap();
    }
    assert_eq!(after.mirror().scene().unwrap(), tidy(7, 60));
    let closing = std::thread::spawn(move || server.close(1000, "done", LONG));
    for c in [&mut early, &mut second, &mut late, &mut after] {
        let end = to_the_end(c);
        assert!(matches!(&end, Gone::Closed(1000, reason) if reason == "done"), "{end}");
        assert_eq!(c.mirror().end().unwrap(), &(Ending::Done, "that was all".to_owned()));
    }
    closing.join().unwrap();
}

/// One reads nothing until all is over, one nothing at all. Neither keeps the server from going on, nor the third from knowing
/// every moment.
#[test]
fn slow_clients_delay_nobody_and_are_brought_up_to_date() {
    let options = Options { queue_bytes: 50_000, stall: Duration::from_millis(300), lag: LONG, ..Options::default() };
    let (server, inbox) = server(options);
    let mut hello = hello();
    hello.size = [500, 500];
    server.hello(hello);
    let big = |step: u64| Scene {
        layers: vec![Some(Raster { width: 500, values: vec![step as f32; 250_000] })],
        ..scene(step)
    };
    let mut quick = client(&server);
    joined(&inbox);
    // With a megabyte a moment, forty are more than any buffer of the system holds.
    let deaf = TcpStream::connect(server.address()).unwrap();
    shake(&deaf);
    server.publish(big(0));
    for step in 0..40 {
        until(&mut quick, step);
        assert!(quick.mirror().scene().unwrap().layers == big(step).layers);
        server.publish(big(step + 1));
    }
    assert_eq!(quick.mirror().snapshots(), 1);
    assert_eq!(left(&inbox, 2), "it took nothing for too long");
    drop(deaf);

    // This one is only slow: it comes back before it is cut off, to the last state and not through all of them.
    drop(server);
    let options = Options { queue_bytes: 50_000, stall: LONG, lag: Duration::from_millis(1), ..Options::default() };
    let (server, _) = self::server(options);
    let mut hello = self::hello();
    hello.size = [500, 500];
    server.hello(hello);
    let mut slow = client(&server);
    server.publish(big(0));
    until(&mut slow, 0);
    (1..40).for_each(|step| server.publish(big(step)));
    let until_step = |c: &mut Client, step| {
        let mut moments = 0;
        // A moment is looked at when it is complete.
        loop {
            let is_complete = c.follow().unwrap().is_some();
            moments += usize::from(is_complete);
            if is_complete && c.mirror().moment().unwrap().steps_done >= step {
                break moments;
            }
        }
    };
    let moments = until_step(&mut slow, 39);
    assert!(slow.mirror().scene().unwrap().layers == big(39).layers);
    assert!(moments < 39, "it went through all {moments} of them");
    server.publish(big(40));
    until_step(&mut slow, 40);
    assert!(slow.mirror().scene().unwrap().layers == big(40).layers);
}

/// A handshake by hand, for what no library sends.
fn shake(mut stream: &TcpStream) {
    let request = "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
                   Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    while !answer.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte).unwrap();
        answer.push(byte[0]);
    }
    assert!(answer.starts_with(b"HTTP/1.1 101"), "{}", String::from_utf8_lossy(&answer));
}

#[test]
fn garbage_closes_its_sender_and_nobody_else() {
    let (server, inbox) = server(Options::default());
    server.publish(scene(0));
    let mut good = client(&server);
    joined(&inbox);
    let mut cut = Record::from(Body::Order(Order::Step(3))).encode();
    cut.truncate(20);
    let cases = [
        (Message::Binary(b"nonsense".to_vec().into()), 1007),
        (Message::Binary(Vec::new().into()), 1007),
        (Message::Binary(cut.into()), 1007),
        (Message::Binary(Record::from(Body::Status(Status::Runs)).encode().into()), 1007),
        (Message::Text("pause".into()), 1003),
        (Message::Binary(vec![0; 5000].into()), 1009),
    ];
    for (message, code) in cases {
        let mut rude = client(&server);
        until(&mut rude, 0);
        rude.send(message).unwrap();
        let end = to_the_end(&mut rude);
        assert!(matches!(end, Gone::Closed(c, ref reason) if c == code && !reason.is_empty()), "{code}: {end}");
    }
    // Frames that are none, and text that is no UTF-8, masked as the protocol wants it.
    for (bytes, code) in [(&[0xff; 40][..], 1002), (&[0x82, 0x02, 0, 0], 1002), (&[0x81, 0x81, 0, 0, 0, 0, 0xff], 1007)]
    {
        let rude = TcpStream::connect(server.address()).unwrap();
        rude.set_read_timeout(Some(LONG)).unwrap();
        shake(&rude);
        (&rude).write_all(bytes).unwrap();
        let mut all = Vec::new();
        (&rude).read_to_end(&mut all).unwrap();
        let found = all.windows(2).any(|w| w == u16::to_be_bytes(code));
        assert!(found && all.contains(&0x88), "no close with {code} in {} bytes", all.len());
    }
    // A flood of pings.
    let mut loud = client(&server);
    let mut sent = 0;
    while sent < 500 && loud.send(Message::Ping(Vec::new().into())).is_ok() {
        sent += 1;
    }
    let end = to_the_end(&mut loud);
    assert!(matches!(end, Gone::Closed(1008, _) | Gone::Broken(_)), "{end}");
    let mut gone = HashSet::new();
    while gone.len() < 10 {
        if let Notice::Left { client, .. } = inbox.recv_timeout(LONG).unwrap() {
            gone.insert(client);
        }
    }
    assert_eq!(gone, (2..=11).collect());
    for step in 1..10 {
        server.publish(scene(step));
        until(&mut good, step);
    }
    assert_eq!(good.mirror().scene().unwrap(), tidy(9, 9));
    assert_eq!(server.clients(), 1);
}

#[test]
fn doors_are_guarded() {
    let (server, inbox) =
        server(Options { max_clients: 2, allow_origins: vec!["https://example.org".into()], ..Options::default() });
    let refused = |inbox: &Receiver<Notice>| loop {
        if let Notice::Refused { reason, .. } = inbox.recv_timeout(LONG).unwrap() {
            return reason;
        }
    };
    let foreign = Client::connect_from(server.address(), "https://evil.example");
    assert!(foreign.is_err_and(|e| e.to_string().contains("403")));
    assert!(refused(&inbox).contains("https://evil.example"));
    assert!(Client::connect_from(server.address(), "null").is_err());
    refused(&inbox);
    let one = Client::connect_from(server.address(), "https://example.org").unwrap();
    joined(&inbox);
    let two = Client::connect_from(server.address(), "http://localhost:8000").unwrap();
    let third = Client::connect(server.address());
    assert!(third.is_err_and(|e| e.to_string().contains("503")));
    refused(&inbox);
    let mut other = TcpStream::connect(server.address()).unwrap();
    other.write_all(b"SSH-2.0-hello\r\n\r\n").unwrap();
    refused(&inbox);
    drop(one);
    assert_eq!(left(&inbox, 1), "it went");
    let again = Client::connect(server.address());
    assert!(again.is_ok());
    drop(two);
}

#[test]
fn only_this_machine_unless_asked() {
    let open = |public| {
        let listen = SocketAddr::from(([0, 0, 0, 0], 0));
        Server::bind(Options { listen, public, ..Options::default() }, |_| {}).map(|s| s.address())
    };
    assert!(open(false).unwrap_err().to_string().contains("0.0.0.0"));
    assert!(open(true).unwrap().port() > 0);
    let (server, _) = server(Options::default());
    let taken = Server::bind(Options { listen: server.address(), ..Options::default() }, |_| {});
    assert!(taken.is_err_and(|e| e.to_string().contains(&server.address().to_string())));
}

#[test]
fn orders_arrive_or_are_refused() {
    let orders = [Order::Pause, Order::Step(12), Order::Resume];
    let control = Control::Token("open-sesame".into());
    let (server, inbox) = server(Options { control, ..Options::default() });
    let mut c = Client::connect_with(server.address(), "open-sesame").unwrap();
    c.set_patience(Some(LONG)).unwrap();
    for order in orders {
        c.order(order.clone()).unwrap();
        loop {
            if let Notice::Order { client, order: heard } = inbox.recv_timeout(LONG).unwrap() {
                assert_eq!((client, heard), (1, order));
                break;
            }
        }
    }
    server.status(Status::Paused);
    while c.mirror().status() != Status::Paused {
        c.follow().unwrap();
    }
    assert_eq!(c.mirror().hello().unwrap().may, Permission::Pause);
    // The token lets nobody change anything where the server does not.
    c.set("hydraulic.rain", "0.5").unwrap();
    while c.mirror().refused().is_none() {
        c.follow().unwrap();
    }
    assert!(c.mirror().refused().unwrap().contains("nobody may change this run"));
    // Whoever does not know the token watches, pages of this machine too.
    let page = Client::connect_from(server.address(), "http://localhost:8000").unwrap();
    let guess = Client::connect_with(server.address(), "open-sesam").unwrap();
    let (read_only, _) = self::server(Options::default());
    for (mut c, server, reason) in
        [(page, &server, "the token"), (guess, &server, "the token"), (client(&read_only), &read_only, "no orders")]
    {
        c.set_patience(Some(LONG)).unwrap();
        c.order(Order::Pause).unwrap();
        while c.mirror().refused().is_none() {
            c.follow().unwrap();
        }
        assert!(c.mirror().refused().unwrap().contains(reason) && c.mirror().hello().unwrap().may == Permission::Watch);
        server.publish(scene(0));
        while c.follow().unwrap().is_none() {}
    }
    assert!(!inbox.try_iter().any(|n| matches!(n, Notice::Order { .. })));
}

/// Half a handshake holds nobody's place for ever.
#[test]
fn half_a_handshake_is_cut_in_time() {
    let (server, inbox) = server(Options { handshake: Duration::from_millis(100), ..Options::default() });
    let mut half = TcpStream::connect(server.address()).unwrap();
    half.write_all(b"GET / HTTP/1.1\r\nHost: lo").unwrap();
    loop {
        if let Notice::Refused { reason, .. } = inbox.recv_timeout(LONG).unwrap() {
            break assert!(reason.contains("took too long"), "{reason}");
        }
    }
}

/// One that is there and answers nothing is found out when there is nothing to send it, such as while the run is paused; one that does
/// answer stays.
#[test]
fn silent_clients_are_cut_off() {
    let soon = Duration::from_millis(100);
    let (server, inbox) = server(Options { ping: soon, stall: 3 * soon, ..Options::default() });
    server.publish(scene(0));
    let silent = TcpStream::connect(server.address()).unwrap();
    shake(&silent);
    assert_eq!(left(&inbox, 1), "it answered no ping");
    let (server, inbox) = self::server(Options { ping: soon, stall: LONG, ..Options::default() });
    server.publish(scene(0));
    let mut good = client(&server);
    until(&mut good, 0);
    let reading = std::thread::spawn(move || to_the_end(&mut good));
    std::thread::sleep(5 * soon);
    assert_eq!(server.clients(), 1);
    drop(server);
    assert!(matches!(reading.join().unwrap(), Gone::Broken(_)));
    assert!(matches!(inbox.recv().unwrap(), Notice::Joined { .. }));
}

/// Nothing is made for those who take nothing, and states that nobody could follow are skipped: to publish them takes no time.
#[test]
fn states_that_come_too_fast_are_skipped() {
    let (server, _) = server(Options { queue_bytes: 10_000, ..Options::default() });
    let mut c = client(&server);
    server.publish(scene(0));
    until(&mut c, 0);
    (1..2000).for_each(|step| server.publish(scene(step)));
    server.end(Ending::Done, "that was all");
    while c.mirror().end().is_none() {
        c.follow().unwrap();
    }
    assert_eq!(c.mirror().moment().unwrap().steps_done, 1999);
    assert_eq!(c.mirror().scene().unwrap().layers, tidy(1999, 0).layers);
}

/// Clients that were there before anything was known get everything in the right order.
#[test]
fn who_comes_before_the_hello_waits_for_it() {
    let server = Server::bind(Options::default(), |_| {}).unwrap();
    let mut c = client(&server);
    while server.clients() == 0 {
        std::thread::yield_now();
    }
    server.publish(scene(0));
    server.status(Status::Waits);
    server.hello(hello());
    server.publish(scene(1));
    until(&mut c, 0);
    assert_eq!(c.mirror().scene().unwrap(), tidy(1, 0));
    while c.mirror().status() != Status::Waits {
        c.follow().unwrap();
    }
}

#[test]
fn a_mirror_refuses_what_does_not_fit() {
    let take = |m: &mut Mirror, more, body| m.take(Record { more, body });
    let mut m = Mirror::default();
    assert!(take(&mut m, 0, Body::Gone(vec![])).is_err());
    assert!(take(&mut m, 0, Body::Step(Moment::default())).is_err());
    let fresh = || {
        let mut m = Mirror::default();
        take(&mut m, 0, Body::Hello(hello())).unwrap();
        take(&mut m, 0, Body::Snapshot(Moment { number: 4, ..Moment::default() })).unwrap();
        m
    };
    let next = |living| Body::Step(Moment { number: 5, living, ..Moment::default() });
    assert!(take(&mut fresh(), 0, next([0, 0])).unwrap());
    assert!(take(&mut fresh(), 0, next([1, 0])).is_err());
    assert!(take(&mut fresh(), 0, Body::Step(Moment { number: 6, ..Moment::default() })).is_err());
    let mut m = fresh();
    assert!(!take(&mut m, 1, next([0, 0])).unwrap());
    assert!(take(&mut m, 0, Body::Status(Status::Runs)).is_err());
    let mut m = fresh();
    take(&mut m, 1, next([0, 0])).unwrap();
    assert!(take(&mut m, 0, Body::Gone(vec![3])).unwrap_err().contains("never was there"));
}

/// What asks for something else hears in its own language what there is.
#[test]
fn bad_handshakes_get_an_answer() {
    let (server, _) = server(Options { handshake: Duration::from_millis(500), ..Options::default() });
    let upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    for (request, status) in [
        ("GET / HTTP/1.1\r\nHost: x\r\n\r\n".to_owned(), "426"),
        (format!("GET / HTTP/1.1\r\nHost: x\r\n{upgrade}Sec-WebSocket-Version: 8\r\n\r\n"), "426"),
        (format!("POST / HTTP/1.1\r\nHost: x\r\n{upgrade}Sec-WebSocket-Version: 13\r\n\r\n"), "405"),
        (format!("GET / HTTP/1.0\r\nHost: x\r\n{upgrade}Sec-WebSocket-Version: 13\r\n\r\n"), "505"),
        ("SSH-2.0-hello\r\n\r\n".to_owned(), "400"),
        ("GET / HTTP/1.1\r\nHost: lo".to_owned(), "408"),
    ] {
        let mut stream = TcpStream::connect(server.address()).unwrap();
        stream.set_read_timeout(Some(LONG)).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "{request}: {answer}");
        let (head, text) = answer.split_once("\r\n\r\n").unwrap();
        assert!(head.contains(&format!("Content-Length: {}", text.len())), "{answer}");
    }
}

/// Connections that come again and again and never shake hands: whoever speaks is let in all the same.
#[test]
fn churning_handshakes_keep_nobody_out() {
    let (server, _) = server(Options { handshake: LONG, ..Options::default() });
    server.publish(scene(0));
    let done = Arc::new(AtomicBool::new(false));
    let churn = {
        let (done, address) = (done.clone(), server.address());
        std::thread::spawn(move || {
            let mut held = std::collections::VecDeque::new();
            while !done.load(Ordering::Relaxed) {
                held.extend(TcpStream::connect_timeout(&address, Duration::from_millis(50)));
                if held.len() > 32 {
                    held.pop_front();
                }
            }
        })
    };
    for _ in 0..5 {
        until(&mut client(&server), 0);
    }
    done.store(true, Ordering::Relaxed);
    churn.join().unwrap();
}

/// More silent connections than handshakes may be under way: whoever speaks is let in all the same.
#[test]
fn those_who_say_nothing_keep_nobody_out() {
    let (server, inbox) = server(Options { handshake: LONG, ..Options::default() });
    let silent: Vec<TcpStream> = (0..40).map(|_| TcpStream::connect(server.address()).unwrap()).collect();
    for _ in 0..24 {
        // All but sixteen are cut before their time.
        while !matches!(inbox.recv_timeout(LONG / 2).unwrap(), Notice::Refused { .. }) {}
    }
    let mut clients: Vec<Client> = (0..3).map(|_| client(&server)).collect();
    server.publish(scene(0));
    clients.iter_mut().for_each(|c| until(c, 0));
    drop(silent);
}
