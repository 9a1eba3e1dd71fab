// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Two nodes of this process talk to each other over DDS: topics, services, actions, parameters, life cycle, time.

use std::{
    sync::{
        Arc, Mutex,
        atomic::{AtomicUsize, Ordering},
        mpsc,
    },
    time::{Duration, Instant},
};

use camwright_msgs::{
    diagnostic_msgs::msg::DiagnosticArray,
    rcl_interfaces::{
        msg::{Log, Parameter as ParameterMsg, ParameterEvent, ParameterValue as ValueMsg},
        srv::{
            DescribeParameters, DescribeParametersRequest, GetParameters, GetParametersRequest, ListParameters,
            ListParametersRequest, SetParameters, SetParametersAtomically, SetParametersAtomicallyRequest,
            SetParametersRequest,
        },
    },
    rosgraph_msgs::msg::Clock,
    std_msgs::msg::{Float64, String as Text},
    std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerRequest, TriggerResponse},
};
use camwright_ros::{
    DelayInjection, Level, Node, NodeOptions, Parameter, ParameterValue, Qos, RosArgs, RosError, SpinThread,
    diagnostic_status,
};

use crate::support;

use support::Domain;

/// Generous: the machine may be building at the same time.
const PATIENCE: Duration = Duration::from_secs(20);

fn args(domain: &Domain, text: &str) -> RosArgs {
    let words: Vec<String> = text.split_whitespace().map(str::to_string).collect();
    let (args, rest) = RosArgs::parse_with(&words, |_| None).expect("valid arguments");
    assert!(rest.is_empty());
    args.with_domain_id(domain.id())
}

fn node(domain: &Domain, name: &str) -> (Node, SpinThread) {
    start(NodeOptions::new(name, &args(domain, "")))
}

fn start(options: NodeOptions) -> (Node, SpinThread) {
    let node = Node::new(options).expect("a node");
    let thread = node.spin_in_thread().expect("a thread");
    (node, thread)
}

fn until(what: &str, condition: impl Fn() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn reliable_messages_arrive_in_order_with_their_numbers_and_times() {
    let domain = Domain::reserve();
    let (talker, _a) = node(&domain, "talker");
    let (listener, _b) = node(&domain, "listener");
    let publisher = talker.publisher::<Float64>("numbers", &Qos::default_topic()).expect("a publisher");
    let (sender, receiver) = mpsc::channel();
    let subscription = listener
        .subscribe::<Float64>("numbers", &Qos::default_topic().keep_last(1000), move |message, info| {
            let _ = sender.send((message.data, *info));
        })
        .expect("a subscription");
    assert!(publisher.wait_matched(1, PATIENCE));
    assert!(subscription.wait_matched(1, PATIENCE));
    assert_eq!((publisher.topic(), publisher.matched()), ("/numbers", 1));
    for number in 0..500_i32 {
        publisher.publish(&Float64 { data: number.into() }).expect("published");
    }
    for number in 0..500_i32 {
        let (data, info) = receiver.recv_timeout(PATIENCE).expect("a message");
        assert!((data - f64::from(number)).abs() < 0.5, "{data} after {number}");
        assert_eq!(info.sequence_number, i64::from(number) + 1);
        assert_eq!(info.writer, publisher.guid());
        let age = info.reception_timestamp_ns - info.source_timestamp_ns.expect("stamped");
        assert!((-1_000_000..20_000_000_000).contains(&age), "{age} ns from publisher to subscription");
    }
    assert!(listener.wait_for_node("/talker", PATIENCE));
    // The endpoints of a node are discovered a little later than the node.
    until("the publisher is known with its node", || {
        let topics = listener.discovered_topics();
        let topic = topics.iter().find(|topic| topic.name == "/numbers").expect("known");
        assert_eq!((topic.type_name.as_str(), topic.publishers.len()), ("std_msgs/msg/Float64", 1));
        topic.publishers[0].node.as_deref() == Some("/talker")
    });
    assert_eq!(listener.publisher_count("numbers").expect("valid"), 1);
    drop(publisher);
    until("a dropped publisher is forgotten", || subscription.matched() == 0);
}

#[test]
fn late_joiners_get_latched_messages_and_nothing_else() {
    let domain = Domain::reserve();
    let (talker, _a) = node(&domain, "talker");
    let latched = talker.publisher::<Text>("latched", &Qos::latched(2)).expect("a publisher");
    let volatile = talker.publisher::<Text>("volatile", &Qos::default_topic()).expect("a publisher");
    for text in ["one", "two", "three"] {
        let text = Text { data: text.into() };
        latched.publish(&text).expect("published");
        volatile.publish(&text).expect("published");
    }
    let (listener, _b) = node(&domain, "listener");
    let (sender, receiver) = mpsc::channel();
    let from_volatile = sender.clone();
    let _latched = listener
        .subscribe::<Text>("latched", &Qos::latched(10), move |text, _| drop(sender.send(text.data)))
        .expect("a subscription");
    let _volatile = listener
        .subscribe::<Text>("volatile", &Qos::default_topic(), move |text, _| drop(from_volatile.send(text.data)))
        .expect("a subscription");
    assert!(volatile.wait_matched(1, PATIENCE) && latched.wait_matched(1, PATIENCE));
    latched.publish(&Text { data: "four".into() }).expect("published");
    let mut seen = Vec::new();
    while seen.last().is_none_or(|last| last != "four") {
        seen.push(receiver.recv_timeout(PATIENCE).expect("a message"));
    }
    assert!(seen.ends_with(&["two".into(), "three".into(), "four".into()]), "{seen:?}");
}

/// Nodes that share a process deliver to each other directly; a node elsewhere gets the same messages over DDS, each once.
#[test]
fn nodes_of_one_process_deliver_directly_and_to_others_over_dds() {
    let domain = Domain::reserve();
    let together = args(&domain, "").with_intra_process();
    let (talker, _a) = start(NodeOptions::new("talker", &together));
    let (near, _b) = start(NodeOptions::new("near", &together));
    let publisher = talker.publisher::<Float64>("numbers", &Qos::default_topic()).expect("a publisher");
    let latched = talker.publisher::<Float64>("latched", &Qos::latched(2)).expect("a publisher");
    let listen = |node: &Node, topic: &str, qos: &Qos| {
        let (sender, receiver) = mpsc::channel();
        let subscription = node
            .subscribe::<Float64>(topic, qos, move |message, info| {
                let _ = sender.send((message.data, info.sequence_number));
            })
            .expect("a subscription");
        (subscription, receiver)
    };
    let many = Qos::default_topic().keep_last(1000);
    let (_near, from_near) = listen(&near, "numbers", &many);
    let send = |range: std::ops::Range<i32>| {
        for number in range {
            publisher.publish(&Float64 { data: number.into() }).expect("published");
            latched.publish(&Float64 { data: number.into() }).expect("published");
        }
    };
    send(0..10);
    let (far, _c) = node(&domain, "far");
    let (far_numbers, from_far) = listen(&far, "numbers", &many);
    let (_far_latched, latched_far) = listen(&far, "latched", &Qos::latched(2));
    let (_near_latched, latched_near) = listen(&near, "latched", &Qos::latched(2));
    // Both subscriptions match; the far one is reached from then on.
    assert!(publisher.wait_matched(2, PATIENCE) && far_numbers.wait_matched(1, PATIENCE));
    assert!(latched.wait_matched(2, PATIENCE));
    send(10..20);
    let next = |receiver: &mpsc::Receiver<(f64, i64)>| receiver.recv_timeout(PATIENCE).expect("a message");
    for number in 0..20 {
        assert_eq!(next(&from_near), (f64::from(number), i64::from(number) + 1));
    }
    for number in 10..20 {
        assert_eq!(from_far.recv_timeout(PATIENCE).map(|(value, _)| value), Ok(f64::from(number)));
    }
    let until_last = |receiver: &mpsc::Receiver<(f64, i64)>| {
        let mut values = Vec::new();
        while values.last() != Some(&19.0) {
            values.push(next(receiver).0);
        }
        values
    };
    let (near_values, far_values) = (until_last(&latched_near), until_last(&latched_far));
    assert_eq!(near_values, (8..20).map(f64::from).collect::<Vec<_>>(), "the last two, then the new ones");
    assert!(far_values.windows(2).all(|pair| pair[0] < pair[1]), "{far_values:?}");
    // DDS brings nothing a second time.
    publisher.publish(&Float64 { data: 99.0 }).expect("published");
    assert_eq!((next(&from_near).0, next(&from_far).0), (99.0, 99.0));
    assert!(from_near.try_recv().is_err() && latched_near.try_recv().is_err());
}

/// A subscription of the process that is busy makes a reliable publisher wait and then fail; nothing that was accepted is lost.
#[test]
fn a_busy_node_of_the_process_keeps_its_publishers_waiting() {
    let domain = Domain::reserve();
    let together = args(&domain, "").with_intra_process();
    let (talker, _a) = start(NodeOptions::new("talker", &together));
    let (busy, _b) = start(NodeOptions::new("busy", &together));
    let publisher = talker.publisher::<Float64>("numbers", &Qos::default_topic()).expect("a publisher");
    let (go, wait) = mpsc::channel::<()>();
    let (sender, receiver) = mpsc::channel();
    let mut is_first = true;
    let _subscription = busy
        .subscribe::<Float64>("numbers", &Qos::default_topic(), move |message, _| {
            if std::mem::take(&mut is_first) {
                wait.recv_timeout(PATIENCE).expect("the test lets it go on");
            }
            let _ = sender.send(message.data);
        })
        .expect("a subscription");
    assert!(publisher.wait_matched(1, PATIENCE));
    let mut accepted = 0_u32;
    let refused = loop {
        match publisher.publish(&Float64 { data: f64::from(accepted) }) {
            Ok(()) => accepted += 1,
            Err(error) => break error,
        }
        assert!(accepted < 100_000, "it never waits");
    };
    assert!(matches!(refused, RosError::Congested { .. }), "{refused}");
    go.send(()).expect("it waits");
    for number in 0..accepted {
        assert_eq!(receiver.recv_timeout(PATIENCE), Ok(f64::from(number)));
    }
    publisher.publish(&Float64 { data: -1.0 }).expect("there is room again");
    assert_eq!(receiver.recv_timeout(PATIENCE), Ok(-1.0));
}

/// A reader that lags behind costs events of calls, which are counted, and never keeps a call waiting.
#[test]
fn calls_do_not_wait_for_a_reader_of_their_events() {
    const CALLS: u64 = 2500;
    let domain = Domain::reserve();
    let words = "--ros-args -p service_configure_introspection:=metadata";
    let together = args(&domain, words).with_intra_process();
    let (server, _a) = start(NodeOptions::new("server", &together));
    let (busy, _b) = start(NodeOptions::new("busy", &together));
    let (user, _c) = node(&domain, "user");
    let answer = |request: SetBoolRequest| SetBoolResponse { success: request.data, message: String::new() };
    let _flip = server.service::<SetBool>("~/flip", answer).expect("a service");
    let _reports = server.diagnostics("test", || vec![diagnostic_status(0, "", "works", &[])]).expect("diagnostics");
    let (go, wait) = mpsc::channel::<()>();
    let (topic, type_name) = ("/server/flip/_service_event", "std_srvs/srv/SetBool_Event");
    let read = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&read);
    let events = busy
        .subscribe_raw(topic, type_name, &Qos::default_topic(), move |_, _| {
            if counter.fetch_add(1, Ordering::AcqRel) == 0 {
                wait.recv_timeout(PATIENCE).expect("the test lets it go on");
            }
        })
        .expect("a subscription");
    assert!(events.wait_matched(1, PATIENCE));
    let dropped = Arc::new(AtomicUsize::new(0));
    let seen = Arc::clone(&dropped);
    let _diagnostics = user
        .subscribe::<DiagnosticArray>("/diagnostics", &Qos::default_topic(), move |message, _| {
            let values = message.status.iter().flat_map(|status| &status.values);
            for value in values.filter(|value| value.key == "service events dropped") {
                seen.store(value.value.parse().expect("a number"), Ordering::Release);
            }
        })
        .expect("a subscription");
    let client = user.client::<SetBool>("/server/flip").expect("a client");
    for _ in 0..CALLS {
        assert!(client.call(&SetBoolRequest { data: true }, PATIENCE).expect("an answer").success);
    }
    until("the dropped events are reported", || dropped.load(Ordering::Acquire) > 0);
    go.send(()).expect("it waits");
    let accounted = || (read.load(Ordering::Acquire) + dropped.load(Ordering::Acquire)) as u64;
    until("every event is read or counted as dropped", || accounted() == 2 * CALLS);
}

/// Messages that a node has already received on a topic are not delivered to its next subscription.
#[test]
fn a_second_subscription_of_a_node_hears_only_what_comes_after_it() {
    let domain = Domain::reserve();
    let (talker, _a) = node(&domain, "talker");
    let publisher = talker.publisher::<Text>("volatile", &Qos::default_topic()).expect("a publisher");
    let (listener, _b) = node(&domain, "listener");
    let hear = || {
        let (sender, receiver) = mpsc::channel();
        let receive = move |text: Text, _: &_| drop(sender.send(text.data));
        let subscription = listener.subscribe::<Text>("volatile", &Qos::default_topic(), receive);
        (subscription.expect("a subscription"), receiver)
    };
    let say = |text: &str| publisher.publish(&Text { data: text.into() }).expect("published");
    let (_first, first) = hear();
    assert!(publisher.wait_matched(1, PATIENCE));
    say("before");
    assert_eq!(first.recv_timeout(PATIENCE).as_deref(), Ok("before"));
    let (_second, second) = hear();
    assert!(publisher.wait_matched(2, PATIENCE));
    say("after");
    assert_eq!(second.recv_timeout(PATIENCE).as_deref(), Ok("after"));
    assert_eq!(first.recv_timeout(PATIENCE).as_deref(), Ok("after"));
}

#[test]
fn raw_messages_are_the_typed_ones() {
    let domain = Domain::reserve();
    let (node, _a) = node(&domain, "both");
    let raw = node.raw_publisher("text", "std_msgs/msg/String", &Qos::default_topic()).expect("a publisher");
    let (sender, receiver) = mpsc::channel();
    let (raw_sender, raw_receiver) = mpsc::channel();
    let typed = node
        .subscribe::<Text>("text", &Qos::default_topic(), move |text, _| drop(sender.send(text.data)))
        .expect("a subscription");
    let untyped = node
        .subscribe_raw("text", "std_msgs/msg/String", &Qos::default_topic(), move |cdr, _| {
            drop(raw_sender.send(cdr.to_vec()));
        })
        .expect("a subscription");
    let both = raw.wait_matched(2, PATIENCE);
    assert!(both, "a node hears itself: {} {} {}", raw.matched(), typed.matched(), untyped.matched());
    assert!(typed.wait_matched(1, PATIENCE) && untyped.wait_matched(1, PATIENCE));
    let cdr = [0, 1, 0, 0, 4, 0, 0, 0, b'c', b'a', b'm', 0];
    raw.publish(&cdr).expect("published");
    assert_eq!(receiver.recv_timeout(PATIENCE).as_deref(), Ok("cam"));
    assert_eq!(raw_receiver.recv_timeout(PATIENCE).expect("a message"), cdr);
    assert!(raw.publish(&[0, 0, 0, 0, 1]).is_err(), "big-endian is refused");
    assert!(raw.publish(&[]).is_err());
    assert!(node.raw_publisher("text", "String", &Qos::default_topic()).is_err());
}

#[test]
fn services_answer_at_once_later_and_many_clients_at_the_same_time() {
    let domain = Domain::reserve();
    let (server, _a) = node(&domain, "server");
    let (caller, _b) = node(&domain, "caller");
    let _trigger = server
        .service::<Trigger>("~/trigger", |_| TriggerResponse { success: true, message: "done".into() })
        .expect("a service");
    let _later = server
        .service_deferred::<SetBool>("later", |request: SetBoolRequest, responder| {
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(if request.data { 60 } else { 5 }));
                responder.send(&SetBoolResponse { success: request.data, message: String::new() });
            });
        })
        .expect("a service");
    let trigger = caller.client::<Trigger>("/server/trigger").expect("a client");
    trigger.wait_for_service(PATIENCE).expect("the service is there");
    let answer = trigger.call(&TriggerRequest::default(), PATIENCE).expect("an answer");
    assert!(answer.success && answer.message == "done");

    let later = caller.client::<SetBool>("later").expect("a client");
    let other = caller.client::<SetBool>("later").expect("a second client of the same service");
    later.wait_for_service(PATIENCE).expect("the service is there");
    other.wait_for_service(PATIENCE).expect("the service is there");
    std::thread::scope(|scope| {
        for number in 0..8 {
            let client = if number % 2 == 0 { later.clone() } else { other.clone() };
            scope.spawn(move || {
                let data = number % 3 == 0;
                let answer = client.call(&SetBoolRequest { data }, PATIENCE).expect("an answer");
                assert_eq!(answer.success, data, "answers are not mixed up");
            });
        }
    });

    // A call from a callback would wait for itself.
    let (sender, receiver) = mpsc::channel();
    let inside = trigger.clone();
    caller.post(move || drop(sender.send(inside.call(&TriggerRequest::default(), PATIENCE))));
    assert!(matches!(receiver.recv_timeout(PATIENCE), Ok(Err(RosError::WouldDeadlock { .. }))));
    let absent = caller.client::<Trigger>("absent").expect("a client");
    assert!(matches!(
        absent.call(&TriggerRequest::default(), Duration::from_millis(50)),
        Err(RosError::Timeout { .. })
    ));
}

/// The race that loses the first reply when a client calls the moment it sees the server.
#[test]
fn the_first_call_of_a_fresh_client_is_answered() {
    let domain = Domain::reserve();
    let (server, _a) = node(&domain, "server");
    let _trigger = server.service::<Trigger>("trigger", |_| TriggerResponse::default()).expect("a service");
    for round in 0..5 {
        let (caller, _b) = node(&domain, &format!("caller{round}"));
        let client = caller.client::<Trigger>("trigger").expect("a client");
        client.wait_for_service(PATIENCE).expect("the service is there");
        let begun = Instant::now();
        client.call(&TriggerRequest::default(), PATIENCE).unwrap_or_else(|error| panic!("round {round}: {error}"));
        println!("round {round}: first call took {:?}", begun.elapsed());
        caller.shutdown();
    }
}

#[test]
fn names_are_remapped_and_two_namespaces_do_not_meet() {
    let domain = Domain::reserve();
    let (one, _a) =
        start(NodeOptions::new("machine", &args(&domain, "--ros-args -r __ns:=/cell1 -r machine/stream:=flow")));
    let (two, _b) = start(NodeOptions::new("machine", &args(&domain, "--ros-args -r __ns:=/cell2 -r __node:=press")));
    assert_eq!((one.fully_qualified_name().as_str(), two.name()), ("/cell1/machine", "press"));
    let out = one.publisher::<Text>("machine/stream", &Qos::default_topic()).expect("a publisher");
    assert_eq!(out.topic(), "/cell1/flow");
    assert_eq!(two.resolve_topic("~/state").expect("valid"), "/cell2/press/state");
    let received = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&received);
    let stray = two
        .subscribe::<Text>("flow", &Qos::default_topic(), move |_, _| {
            count.fetch_add(1, Ordering::SeqCst);
        })
        .expect("a subscription");
    assert!(!stray.wait_matched(1, Duration::from_millis(500)));
    out.publish(&Text::default()).expect("published");
    assert_eq!(received.load(Ordering::SeqCst), 0);
    assert!(matches!(one.publisher::<Text>("a b", &Qos::default_topic()), Err(RosError::Name(_))));
}

#[test]
fn parameters_are_guarded_described_and_reported() {
    let domain = Domain::reserve();
    let options = NodeOptions::new("holder", &args(&domain, "--ros-args -p rate:=5 -p holder:group.name:=given"))
        .parameter(Parameter::double("rate", 1.0).describe("in Hz").range(0.0, 10.0))
        .parameter(Parameter::string("group.name", "default"))
        .parameter(Parameter::integer("axes", 2).integer_range(1, 4).read_only());
    let (holder, _a) = start(options);
    let parameters = holder.parameters().clone();
    assert!((parameters.double("rate") - 5.0).abs() < 1e-12, "1 is meant as 1.0 on a command line");
    assert_eq!(parameters.string("group.name"), "given");
    parameters.on_set(|changes| {
        let forbidden = changes.iter().any(|(_, value)| *value == ParameterValue::String("forbidden".into()));
        if forbidden { Err("that name is taken".into()) } else { Ok(()) }
    });
    let (sender, changed) = mpsc::channel();
    parameters.on_change(move |changes| drop(sender.send(changes.to_vec())));

    let (user, _b) = node(&domain, "user");
    let (sender, events) = mpsc::channel();
    let listening = user
        .subscribe::<ParameterEvent>("/parameter_events", &Qos::parameter_events(), move |event, _| {
            drop(sender.send(event));
        })
        .expect("a subscription");
    assert!(listening.wait_matched(2, PATIENCE));
    let set = user.client::<SetParameters>("/holder/set_parameters").expect("a client");
    set.wait_for_service(PATIENCE).expect("the service is there");
    let number = |name: &str, value: f64| ParameterMsg {
        name: name.into(),
        value: ValueMsg { type_: 3, double_value: value, ..Default::default() },
    };
    let whole = |name: &str, value: i64| ParameterMsg {
        name: name.into(),
        value: ValueMsg { type_: 2, integer_value: value, ..Default::default() },
    };
    let text = |name: &str, value: &str| ParameterMsg {
        name: name.into(),
        value: ValueMsg { type_: 4, string_value: value.into(), ..Default::default() },
    };
    let wanted = vec![
        number("rate", 2.5),
        number("rate", 11.0),
        whole("rate", 3),
        whole("axes", 3),
        number("unknown", 1.0),
        text("group.name", "forbidden"),
        ParameterMsg { name: "rate".into(), value: ValueMsg::default() },
    ];
    let results = set.call(&SetParametersRequest { parameters: wanted }, PATIENCE).expect("an answer").results;
    let outcome: Vec<(bool, &str)> = results.iter().map(|r| (r.successful, r.reason.as_str())).collect();
    assert_eq!(
        outcome,
        [
            (true, ""),
            (false, "parameter 'rate' 11 is outside 0 to 10"),
            (false, "parameter 'rate' has the type double (0 to 10); it cannot be the integer 3"),
            (false, "parameter 'axes' is 2 and read-only; set it at the start, with -p or --params-file"),
            (false, "parameter 'unknown' is not declared"),
            (false, "that name is taken"),
            (false, "parameter 'rate' cannot be removed"),
        ]
    );
    assert_eq!(changed.try_recv(), Ok(vec![("rate".to_string(), ParameterValue::Double(2.5))]));
    assert!(changed.try_recv().is_err());
    let event = events.iter().find(|event| event.node == "/holder" && !event.changed_parameters.is_empty());
    assert_eq!(event.expect("an event").changed_parameters, vec![number("rate", 2.5)]);

    let atomic = user.client::<SetParametersAtomically>("/holder/set_parameters_atomically").expect("a client");
    atomic.wait_for_service(PATIENCE).expect("the service is there");
    let wanted = vec![number("rate", 3.0), whole("axes", 1)];
    let result =
        atomic.call(&SetParametersAtomicallyRequest { parameters: wanted }, PATIENCE).expect("an answer").result;
    assert!(!result.successful);
    assert!((parameters.double("rate") - 2.5).abs() < 1e-12, "all or nothing");

    let describe = user.client::<DescribeParameters>("/holder/describe_parameters").expect("a client");
    describe.wait_for_service(PATIENCE).expect("the service is there");
    let names = vec!["rate".to_string(), "axes".into(), "none".into()];
    let descriptors = describe.call(&DescribeParametersRequest { names }, PATIENCE).expect("an answer").descriptors;
    assert_eq!(descriptors.len(), 3);
    assert_eq!((descriptors[0].type_, descriptors[0].description.as_str()), (3, "in Hz"));
    assert!((descriptors[0].floating_point_range[0].to_value - 10.0).abs() < 1e-12);
    assert!(descriptors[1].read_only && descriptors[1].integer_range[0].from_value == 1);
    assert_eq!(descriptors[2].type_, 0);

    let list = user.client::<ListParameters>("/holder/list_parameters").expect("a client");
    list.wait_for_service(PATIENCE).expect("the service is there");
    let listed = list.call(&ListParametersRequest::default(), PATIENCE).expect("an answer").result;
    // Every node has these.
    let common = [
        "action_client_configure_introspection",
        "action_server_configure_introspection",
        "client_configure_introspection",
        "service_configure_introspection",
        "start_type_description_service",
        "use_sim_time",
    ];
    let (listed_common, own): (Vec<&str>, Vec<&str>) =
        listed.names.iter().map(String::as_str).partition(|name| common.contains(name));
    assert_eq!(own, ["axes", "group.name", "rate"]);
    assert_eq!(listed_common, common);
    assert_eq!(listed.prefixes, ["group"]);

    let get = user.client::<GetParameters>("/holder/get_parameters").expect("a client");
    get.wait_for_service(PATIENCE).expect("the service is there");
    let names = vec!["none".to_string(), "group.name".into()];
    let values = get.call(&GetParametersRequest { names }, PATIENCE).expect("an answer").values;
    assert_eq!((values[0].type_, values[1].string_value.as_str()), (0, "given"));

    let refused = NodeOptions::new("refused", &args(&domain, "--ros-args -p rate:=fast"))
        .parameter(Parameter::double("rate", 1.0));
    assert!(matches!(Node::new(refused), Err(RosError::Parameter { .. })));
}

#[test]
fn simulated_time_comes_from_a_real_clock_topic() {
    let domain = Domain::reserve();
    let (clock, _a) = node(&domain, "clock");
    let (follower, _b) = start(NodeOptions::new("follower", &args(&domain, "--ros-args -p use_sim_time:=true")));
    assert_eq!(follower.now_ns(), 0, "before the first message");
    assert!(clock.now_ns() > 1_700_000_000_000_000_000);
    let publisher = clock.publisher::<Clock>("/clock", &Qos::default_topic()).expect("a publisher");
    assert!(publisher.wait_matched(1, PATIENCE));
    let mut message = Clock::default();
    (message.clock.sec, message.clock.nanosec) = (12, 345);
    until("the clock is followed", || {
        // Best effort: lost if the follower has not found the publisher yet.
        publisher.publish(&message).expect("published");
        follower.now_ns() == 12_000_000_345
    });
    let parameters = follower.parameters();
    parameters.set("use_sim_time", ParameterValue::Bool(false)).expect("allowed");
    assert!(follower.now_ns() > 1_700_000_000_000_000_000);
}

#[test]
fn log_lines_reach_rosout_with_the_name_of_their_node() {
    let domain = Domain::reserve();
    let (speaker, _a) =
        start(NodeOptions::new("speaker", &args(&domain, "--ros-args -r __ns:=/cell --log-level warn")));
    speaker.log(Level::Info, "too quiet");
    speaker.log(Level::Warn, "before anybody listened");
    let (listener, _b) = node(&domain, "listener");
    let (sender, receiver) = mpsc::channel();
    let _rosout = listener
        .subscribe::<Log>("/rosout", &Qos::rosout(), move |log, _| drop(sender.send(log)))
        .expect("a subscription");
    let log = receiver.recv_timeout(PATIENCE).expect("a log message");
    assert_eq!(
        (log.name.as_str(), log.msg.as_str(), log.level),
        ("cell.speaker", "before anybody listened", Log::WARN)
    );
    assert!(log.file.ends_with("ros_layer.rs") && log.line > 0);
}

#[test]
fn two_types_on_one_topic_do_not_meet() {
    let domain = Domain::reserve();
    let (talker, _a) = node(&domain, "talker");
    let (listener, _b) = node(&domain, "listener");
    let wrong = talker.publisher::<Float64>("topic", &Qos::default_topic()).expect("a publisher");
    let right = talker.publisher::<Text>("topic", &Qos::default_topic()).expect("a publisher");
    let (sender, receiver) = mpsc::channel();
    let subscription = listener
        .subscribe::<Text>("topic", &Qos::default_topic(), move |text, _| drop(sender.send(text.data)))
        .expect("a subscription");
    assert!(right.wait_matched(1, PATIENCE) && subscription.wait_matched(1, PATIENCE));
    for number in 0..20_i32 {
        wrong.publish(&Float64 { data: number.into() }).expect("published");
        right.publish(&Text { data: number.to_string() }).expect("published");
    }
    for number in 0..20 {
        assert_eq!(receiver.recv_timeout(PATIENCE), Ok(number.to_string()));
    }
    assert_eq!((wrong.matched(), subscription.matched()), (0, 1));
    let types: Vec<String> = listener
        .discovered_topics()
        .into_iter()
        .filter(|topic| topic.name == "/topic")
        .map(|topic| topic.type_name)
        .collect();
    assert_eq!(types, ["std_msgs/msg/Float64", "std_msgs/msg/String"]);
}

#[test]
fn injected_delays_keep_the_order_within_a_topic() {
    let domain = Domain::reserve();
    let seed = 7;
    println!("seed {seed}");
    let (talker, _a) = node(&domain, "talker");
    let options = NodeOptions::new("delayed", &args(&domain, ""));
    let (listener, _b) = start(options.delay_injection(Some(DelayInjection { seed, max_ms: 20 })));
    let publisher = talker.publisher::<Float64>("numbers", &Qos::default_topic()).expect("a publisher");
    let seen = Arc::new(Mutex::new(Vec::new()));
    let into = Arc::clone(&seen);
    let _subscription = listener
        .subscribe::<Float64>("numbers", &Qos::default_topic(), move |message, _| {
            into.lock().expect("not poisoned").push(message.data);
        })
        .expect("a subscription");
    assert!(publisher.wait_matched(1, PATIENCE));
    let begun = Instant::now();
    for number in 0..50_i32 {
        publisher.publish(&Float64 { data: number.into() }).expect("published");
    }
    until("all arrive", || seen.lock().expect("not poisoned").len() == 50);
    assert!(begun.elapsed() > Duration::from_millis(5), "nothing was delayed");
    assert!(seen.lock().expect("not poisoned").is_sorted());
}

/// Each participant publishes its nodes once, on one topic. What came before the reader has its turn is kept.
#[test]
fn the_nodes_of_all_participants_are_known_to_a_node_that_spins_late() {
    let domain = Domain::reserve();
    let names = ["first", "second", "third", "fourth"];
    let others = names.map(|name| node(&domain, name));
    let late = Node::new(NodeOptions::new("late", &args(&domain, ""))).expect("a node");
    std::thread::sleep(Duration::from_secs(1));
    let _spin = late.spin_in_thread().expect("a thread");
    for name in names {
        let known = late.wait_for_node(&format!("/{name}"), PATIENCE);
        assert!(known, "{name} is missing: {:?}", late.discovered_nodes());
    }
    drop(others);
}

#[test]
fn a_node_that_is_shut_down_is_forgotten_and_refuses_further_work() {
    let domain = Domain::reserve();
    let (stayer, _a) = node(&domain, "stayer");
    let (leaver, thread) = node(&domain, "leaver");
    assert!(stayer.wait_for_node("/leaver", PATIENCE));
    thread.stop();
    leaver.shutdown();
    until("the name is gone", || !stayer.discovered_nodes().contains(&"/leaver".to_string()));
    assert!(matches!(leaver.publisher::<Text>("late", &Qos::default_topic()), Err(RosError::Closed { .. })));
}
