# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Figures for the decision on Zenoh as a second transport (docs/decisions/0097): format, latency, network, restart, access, cost.

usage: python3.11 tests/benchmarks/zenoh/figures.py [--quick] [SECTION...]

Sections: format, latency, network, restart, access, and, only on request, cost (two clean builds) and hiroz (compiles 400 crates). Network
needs root. Everything stays on the loopback interface or in network namespaces. The exit code is 1 if a check fails.
"""
import json
import os
import pathlib
import queue
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", HERE / "target"))
PROGRAM, HIROZ = TARGET / "release/zenoh_spike", TARGET / "hiroz/debug/hiroz_peer"
DOMAIN = "77"
PATIENCE_S = 90
INSIDE, OUTSIDE = "192.0.2.1", "192.0.2.2"
SECTIONS = ("format", "latency", "network", "restart", "access")
failed = []


def check(name, ok, detail=""):
    print(f"{'PASS' if ok else 'FAIL'}  {name}{': ' if detail else ''}{detail}", flush=True)
    if not ok:
        failed.append(name)


def load():
    return pathlib.Path("/proc/loadavg").read_text().split()[0]


class Process:
    """A child whose lines are read as they come; ended when its block is left."""

    def __init__(self, *command, namespace=None, **more):
        command = [str(word) for word in command]
        if namespace:
            command = ["ip", "netns", "exec", namespace, *command]
        env = {**os.environ, "ROS_DOMAIN_ID": DOMAIN, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET" if namespace else "LOCALHOST", **more}
        self.name = " ".join(command[-4:])
        self.child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env)
        self.lines, self.complaints = queue.Queue(), []
        threading.Thread(target=self.read, args=(self.child.stdout, self.lines.put), daemon=True).start()
        threading.Thread(target=self.read, args=(self.child.stderr, self.complaints.append), daemon=True).start()

    def read(self, stream, keep):
        for line in stream:
            keep(line.rstrip("\n"))
        keep(None)

    def line(self, timeout_s=PATIENCE_S):
        try:
            line = self.lines.get(timeout=timeout_s)
        except queue.Empty:
            line = None
        if line is None:
            self.child.kill()
            raise RuntimeError(f"{self.name}: no line in {timeout_s} s; {[text for text in self.complaints if text][-3:]}")
        return line

    def ready(self):
        line = self.line()
        if line != "ready":
            raise RuntimeError(f"{self.name}: `{line}` instead of `ready`")
        return self

    def say(self, text="go"):
        self.child.stdin.write(text + "\n")
        self.child.stdin.flush()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.child.kill()
        self.child.wait()


class Arrivals:
    """What a receiver printed until its end, beside the number of chunks that were sent."""

    def __init__(self, receiver, sent, first_lines=()):
        self.chunks, self.rejected, self.end, first_lines = [], 0, "", list(first_lines)
        while not self.end:
            kind, _, rest = (first_lines.pop(0) if first_lines else receiver.line()).partition(" ")
            if kind == "chunk":
                self.chunks.append(tuple(int(word) for word in rest.split()))
            elif kind == "rejected":
                self.rejected += 1
            else:
                self.end = rest
        numbers = [number for number, _, _ in self.chunks]
        self.missing = sorted(set(range(sent)) - set(numbers))
        self.duplicates = len(numbers) - len(set(numbers))
        self.reordered = sum(after < before for before, after in zip(numbers, numbers[1:]))
        received = [received for _, _, received in self.chunks]
        self.gap_ms = max((after - before for before, after in zip(received, received[1:])), default=0) / 1e6

    def quantile_ms(self, share):
        """The smallest time that this share of the chunks does not exceed, those that were lost being slower than all others."""
        times = sorted(received - sent for _, sent, received in self.chunks)
        index = max(0, -int(-share * (len(times) + len(self.missing)) // 1) - 1)
        return times[index] / 1e6 if index < len(times) else float("inf")

    def row(self):
        times = [f"{self.quantile_ms(share):.3f}" for share in (0.5, 0.99, 1.0)]
        return f"{' | '.join(times)} | {self.gap_ms:.0f} | {len(self.missing)} | {self.duplicates} | {self.reordered}"


HEAD = "p50 ms | p99 ms | max ms | longest gap ms | lost | twice | reordered"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def config(folder, mode, listen=(), connect=(), retry=None, **more):
    """Configuration of a session: what differs from Zenoh's defaults in the default configurations of rmw_zenoh_cpp."""
    text = {
        "mode": mode,
        "listen": {"endpoints": list(listen)},
        "connect": {"endpoints": list(connect), "timeout_ms": {"router": -1, "peer": -1, "client": 10000},
                    "exit_on_failure": {"router": False, "peer": False, "client": True}, "retry": retry or {}},
        "scouting": {"multicast": {"enabled": False},
                     "gossip": {"enabled": True, "target": {"router": ["router", "peer"], "peer": ["router"]},
                                "autoconnect": {"router": [], "peer": ["router", "peer"]},
                                "autoconnect_strategy": {"peer": {"to_router": "always", "to_peer": "greater-zid"}}}},
        "timestamping": {"enabled": True},
        "routing": {"router": {"peers_failover_brokering": True}},
        **more,
    }
    handle, path = tempfile.mkstemp(suffix=".json5", dir=folder)
    with os.fdopen(handle, "w") as file:
        json.dump(text, file)
    return path


def one_host(folder, mode="peer", retry=None):
    """Configurations of a router and of the sessions on its host."""
    port = free_port()
    listen = ["tcp/127.0.0.1:0"] if mode == "peer" else []
    return config(folder, "router", [f"tcp/127.0.0.1:{port}"]), config(folder, mode, listen, [f"tcp/127.0.0.1:{port}"], retry)


def router(path, namespace=None):
    return Process(PROGRAM, "router", path, namespace=namespace).ready()


def stream(sender_config, receiver_config, count, namespaces=(None, None), latched=()):
    """A burst of chunks from a sender to a receiver; what arrived."""
    with Process(PROGRAM, "receive", receiver_config, count, *latched, namespace=namespaces[1]).ready() as receiver:
        with Process(PROGRAM, "send", sender_config, count, *latched, namespace=namespaces[0]).ready() as sender:
            sender.say()
            return Arrivals(receiver, count)


def python():
    """Python of the peer's environment."""
    env = TARGET / "peer"
    wanted = (HERE / "requirements.txt").read_text()
    stamp = env / "requirements.txt"
    if not stamp.exists() or stamp.read_text() != wanted:
        shutil.rmtree(env, ignore_errors=True)
        subprocess.run([sys.executable, "-m", "venv", env], check=True)
        subprocess.run([env / "bin/pip", "install", "-q", "-r", HERE / "requirements.txt"], check=True)
        stamp.write_text(wanted)
    return env / "bin/python"


def peer(path, count, seconds, *more):
    """Report of the peer in Python; `say` of the sender in between makes it see chunks."""
    return Process(python(), HERE / "peer.py", path, count, seconds, *more).ready()


def report(process):
    return json.loads(process.line())


def judge(process, who, count):
    seen = report(process)
    check(f"{who} reads {count} chunks", seen["samples"] >= count and not seen["faults"],
          f"{seen['samples']} of {seen['octets']} octets, {seen['tokens']} tokens; faults: {seen['faults'] or 'none'}")
    service = seen["service"]
    check(f"{who} calls the service", service["answered"] and service.get("same_request", False), json.dumps(service))
    return seen


def format_section(folder, count):
    subprocess.run(["cargo", "test", "--release", "-q", "--manifest-path", HERE / "Cargo.toml", "--bin", "zenoh_spike"], check=True,
                   stdout=subprocess.DEVNULL)
    check("keys, tokens, identities and attachments are those of the documents (cargo test)", True)
    hub, session = one_host(folder)
    with router(hub), Process(PROGRAM, "send", session, 200).ready() as sender:
        with peer(session, 200, 30) as partner:
            sender.say()
            judge(partner, "eclipse-zenoh for Python", 200)
        with Process(PROGRAM, "receive", session, 205).ready() as receiver, peer(session, 0, 1, "hostile") as attacker:
            answers = report(attacker)["hostile"]
            check("malformed requests get one reason each", len(answers) == 4 and all(a.startswith("error: ") for a in answers), str(answers))
            with peer(session, 200, 30) as partner:
                sender.say()
                judge(partner, "after malformed input the peer", 200)
            arrivals = Arrivals(receiver, 0)
            check("malformed samples are rejected, good ones are read", (len(arrivals.chunks), arrivals.rejected) == (200, 5),
                  f"{len(arrivals.chunks)} read, {arrivals.rejected} rejected")


def hiroz_section(folder, count):
    start = time.monotonic()
    subprocess.run(["cargo", "build", "-q", "-j2", "--manifest-path", HERE / "Cargo.toml", "--no-default-features", "--features", "hiroz",
                    "--bin", "hiroz_peer", "--target-dir", TARGET / "hiroz"], check=True, env={**os.environ, "CARGO_PROFILE_DEV_DEBUG": "0"})
    print(f"hiroz compiled in {time.monotonic() - start:.0f} s")
    hub, session = one_host(folder)
    with router(hub), Process(PROGRAM, "send", session, 300).ready() as sender, Process(HIROZ, session, 200).ready() as partner:
        sender.say()
        line = partner.line()
        check("hiroz reads 200 chunks, calls the service and knows our node", line.endswith("service true node true"), line)


def latency_section(folder, count):
    hub, session = one_host(folder)
    rows = []
    keys(folder, ["node"])
    port = free_port()
    tls_hub, tls_session = (config(folder, mode, [f"tls/127.0.0.1:{own}"], connect, **tls(folder, "node"))
                            for mode, own, connect in (("router", port, []), ("peer", 0, [f"tls/127.0.0.1:{port}"])))
    with router(hub), router(tls_hub):
        for _ in range(3):
            for who, where in (("DDS (camwright_ros)", "dds"), ("Zenoh", session), ("Zenoh, TLS", tls_session)):
                rows.append((who, load(), stream(where, where, count)))
    print(f"\nOne host, {count} chunks, 100 a second; one-way, publish to decoded message\n\ntransport | load | {HEAD}")
    for who, busy, arrivals in rows:
        print(f"{who} | {busy} | {arrivals.row()}")
    check("no chunk is lost on one host", not any(arrivals.missing for _, _, arrivals in rows))


class Hosts:
    """Two network namespaces and the cable of the tests between them."""

    def __enter__(self):
        self.names = [f"camwright-zenoh-{os.getpid()}-{end}" for end in ("in", "out")]
        for name in self.names:
            subprocess.run(["ip", "netns", "add", name], check=True)
            subprocess.run(["ip", "-n", name, "link", "set", "lo", "up"], check=True)
        self.cable = Process(sys.executable, ROOT / "tests/support/cable.py", *self.names)
        self.cable.line()
        for name, address in zip(self.names, (INSIDE, OUTSIDE)):
            for words in (["address", "add", f"{address}/24", "dev", "cable"], ["link", "set", "cable", "up"],
                          ["route", "add", "default", "dev", "cable"]):
                subprocess.run(["ip", "-n", name, *words], check=True)
        return self

    def set(self, **settings):
        self.cable.say(json.dumps(settings))
        return json.loads(self.cable.line())

    def __exit__(self, *_):
        self.cable.child.kill()
        self.cable.child.wait()
        for name in self.names:
            subprocess.run(["ip", "netns", "delete", name], check=False)


def network_section(folder, count):
    hub = config(folder, "router", ["tcp/0.0.0.0:7447"])
    other_hub = config(folder, "router", ["tcp/127.0.0.1:7447"], [f"tcp/{INSIDE}:7447"])
    session = config(folder, "peer", ["tcp/127.0.0.1:0"], ["tcp/127.0.0.1:7447"])
    rows = []
    with Hosts() as hosts, router(hub, hosts.names[0]), router(other_hub, hosts.names[1]):
        for faults in ({"delay_s": 0.02, "loss": 0.0}, {"delay_s": 0.02, "loss": 0.05}):
            for who, where in (("DDS (camwright_ros)", "dds"), ("Zenoh, two routers", session)):
                hosts.set(**faults)
                arrivals = stream(where, where, count, hosts.names)
                counted = hosts.set(loss=0.0)
                rows.append((faults, who, load(), arrivals, counted))
    print(f"\nTwo hosts, {count} chunks, 100 a second\n\ndelay, loss | transport | load | {HEAD} | frames passed, lost")
    for faults, who, busy, arrivals, counted in rows:
        print(f"{faults['delay_s'] * 1e3:.0f} ms, {faults['loss']:.0%} | {who} | {busy} | {arrivals.row()} | {counted['passed']}, {counted['lost']}")
        check(f"{who}: every chunk arrives at {faults['loss']:.0%} loss", not arrivals.missing,
              f"{len(arrivals.missing)} missing {arrivals.missing[:8]}")


def restart(folder, mode, latched, count, retry=None):
    """Chunks around a router that is killed after 3 s and started again 3 s later; a receiver that joins in the outage."""
    hub, session = one_host(folder, mode, retry)
    words = ["latched"] if latched else []
    first = router(hub)
    with Process(PROGRAM, "receive", session, count, *words).ready() as receiver:
        with Process(PROGRAM, "send", session, count, *words).ready() as sender:
            sender.say()
            lines = [receiver.line() for _ in range(300)]
            first.__exit__()
            late = Process(PROGRAM, "receive", session, count, *words)
            time.sleep(3)
            again = time.time_ns()
            with router(hub), late:
                arrivals = Arrivals(receiver, count, lines)
                joined = Arrivals(late.ready(), count)
    name = f"{mode}s{', latched' if latched else ''}{', connects every 100 ms' if retry else ''}"
    print(f"{name}: load {load()}; lost {len(arrivals.missing)}, twice {arrivals.duplicates}, longest gap {arrivals.gap_ms:.0f} ms")
    if joined.chunks:
        print(f"  late joiner: {len(set(number for number, _, _ in joined.chunks))} chunks from number {min(joined.chunks)[0]}, "
              f"the first {(joined.chunks[0][2] - again) / 1e6:.0f} ms after the restart")
    return arrivals, joined


def restart_section(folder, count):
    print("\nRouter killed 3 s after the start of the stream, started again 3 s later")
    direct, late = restart(folder, "peer", False, 1200)
    check("sessions on one host: the stream goes on without the router", not direct.missing, f"{len(direct.missing)} lost")
    check("a receiver without a router finds the sender after the restart", bool(late.chunks))
    through, _ = restart(folder, "client", False, 1200)
    check("sessions through the router: the stream goes on after the restart", bool(through.chunks and through.chunks[-1][0] == 1199),
          f"{len(through.missing)} chunks lost")
    often = {"period_init_ms": 100, "period_max_ms": 100, "period_increase_factor": 1}
    quick, _ = restart(folder, "client", False, 1200, often)
    check("the same, connecting every 100 ms", bool(quick.chunks and quick.chunks[-1][0] == 1199), f"{len(quick.missing)} chunks lost")
    kept, late = restart(folder, "client", True, 1200)
    check("latched, through the router: nothing is lost", not kept.missing, f"{len(kept.missing)} lost, {kept.duplicates} twice")
    check("latched: the late joiner has the last 1000 chunks", not set(range(200, 1200)) & set(late.missing),
          f"{1200 - len(late.missing)} of 1200")


def keys(folder, names):
    """An authority and a certificate for each name: what a command `keys` would write."""
    def openssl(*words):
        subprocess.run(["openssl", *words], check=True, cwd=folder, capture_output=True)
    openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "1", "-subj", "/CN=cell authority",
            "-addext", "basicConstraints=critical,CA:TRUE", "-keyout", "ca.key", "-out", "ca.pem")
    extension = pathlib.Path(folder, "extension")
    extension.write_text("subjectAltName=DNS:localhost,IP:127.0.0.1\nextendedKeyUsage=serverAuth,clientAuth\n")
    for name in names:
        openssl("req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", f"/CN={name}", "-keyout", f"{name}.key",
                "-out", f"{name}.csr")
        openssl("x509", "-req", "-in", f"{name}.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-days", "1",
                "-extfile", "extension", "-out", f"{name}.pem")


def tls(folder, name):
    files = {"root_ca_certificate": f"{folder}/ca.pem", "enable_mtls": bool(name)}
    for side in ("listen", "connect") if name else ():
        files |= {f"{side}_private_key": f"{folder}/{name}.key", f"{side}_certificate": f"{folder}/{name}.pem"}
    return {"transport": {"link": {"protocols": ["tls"], "tls": files}}}


def access_rules():
    """Nodes may do everything in their domain, a viewer may subscribe to setpoints, an operator may call the e-stop too."""
    setpoints, estop, graph = (f"{DOMAIN}/machine/setpoints/**", f"{DOMAIN}/machine/estop/**", f"@ros2_lv/{DOMAIN}/**")
    every = ["put", "delete", "declare_subscriber", "query", "reply", "declare_queryable", "liveliness_token", "liveliness_query",
             "declare_liveliness_subscriber"]

    def rule(name, messages, flows, keys):
        return {"id": name, "permission": "allow", "messages": messages, "flows": flows, "key_exprs": keys}
    return {"access_control": {
        "enabled": True, "default_permission": "deny",
        "rules": [rule("all", every, ["ingress", "egress"], [f"{DOMAIN}/**", graph]),
                  rule("ask-graph", ["liveliness_query", "declare_liveliness_subscriber"], ["ingress"], [graph]),
                  rule("tell-graph", ["liveliness_token", "reply"], ["egress"], [graph]),
                  rule("ask-setpoints", ["declare_subscriber"], ["ingress"], [setpoints, f"{DOMAIN}/**"]),
                  rule("tell-setpoints", ["put"], ["egress"], [setpoints]),
                  rule("ask-estop", ["query"], ["ingress"], [estop]),
                  rule("tell-estop", ["reply", "declare_queryable"], ["egress"], [estop])],
        "subjects": [{"id": "nodes", "cert_common_names": ["node"]}, {"id": "viewer", "cert_common_names": ["viewer"]},
                     {"id": "operator", "cert_common_names": ["operator"]}],
        "policies": [{"subjects": ["nodes"], "rules": ["all"]},
                     {"subjects": ["viewer", "operator"], "rules": ["ask-graph", "tell-graph", "ask-setpoints", "tell-setpoints"]},
                     {"subjects": ["operator"], "rules": ["ask-estop", "tell-estop"]}]}}


def access_section(folder, count):
    print()
    keys(folder, ["node", "viewer", "operator"])
    port, own_port = free_port(), free_port()
    hub = config(folder, "router", [f"tls/127.0.0.1:{port}"], **tls(folder, "node"), **access_rules())
    node, other_node = (config(folder, "peer", [f"tls/127.0.0.1:{own}"], [f"tls/127.0.0.1:{port}"], **tls(folder, "node"), **access_rules())
                        for own in (own_port, 0))
    open_node = config(folder, "peer", [f"tcp/127.0.0.1:{own_port}"], [f"tls/127.0.0.1:{port}"],
                       **{**tls(folder, "node"), "transport": {"link": {**tls(folder, "node")["transport"]["link"], "protocols": ["tls", "tcp"]}}})

    def look(name, sender, where, how="client", scheme="tls", more=()):
        own = tls(folder, name) if scheme == "tls" else {}
        listen = ["tls/127.0.0.1:0"] if how == "peer" and name else []
        with peer(config(folder, how, listen, [f"{scheme}/127.0.0.1:{where}"], **own), 100, 5, *more) as partner:
            sender.say()
            return report(partner)

    def sees_nothing(seen):
        return not seen["tokens"] and not seen["samples"] and not seen.get("service", {}).get("answered")

    def words(seen):
        return json.dumps({name: seen.get(name) for name in ("opened", "tokens", "samples", "service", "reason") if seen.get(name) is not None})[:230]

    with router(hub), Process(PROGRAM, "send", node, 150, "latched").ready() as sender:
        operator = look("operator", sender, port)
        check("operator with a key reads chunks and calls the service",
              operator["samples"] >= 100 and operator["service"]["answered"], words(operator))
        viewer = look("viewer", sender, port)
        check("viewer with a key reads chunks", viewer["samples"] >= 100, words(viewer))
        check("viewer cannot call the service", not viewer["service"]["answered"], json.dumps(viewer["service"]))
        with Process(PROGRAM, "receive", other_node, 151, "latched").ready() as receiver:
            for name in ("viewer", "operator"):
                look(name, sender, port, more=["hostile"])
            arrivals = Arrivals(receiver, 0)
            check("viewer and operator cannot publish setpoints", bool(arrivals.chunks) and not arrivals.rejected,
                  f"{len(arrivals.chunks)} chunks of the node, {arrivals.rejected} of others")
        for how in ("client", "peer"):
            for scheme in ("tls", "tcp"):
                for where, place in ((port, "router"), (own_port, "node's own port")):
                    seen = look(None, sender, where, how, scheme)
                    check(f"without a key ({how}, {scheme}, {place}): no topic, no service", sees_nothing(seen), words(seen))
    with router(hub), Process(PROGRAM, "send", open_node, 150, "latched").ready() as sender:
        seen = look(None, sender, own_port, "peer", "tcp")
        check("control: a node that listens on tcp/localhost, the default of rmw_zenoh_cpp, is open beside a router with TLS and rules",
              seen["samples"] > 0 and seen["service"]["answered"], words(seen))


def cost_section(folder, count):
    def packages(*words):
        text = subprocess.run(["cargo", "tree", "--prefix", "none", "-e", "normal", "-f", "{p}|{l}", *words], check=True, capture_output=True,
                              text=True).stdout
        return {tuple(line.replace(" (*)", "").split("|")) for line in text.splitlines() if line}
    manifest = ["--manifest-path", HERE / "Cargo.toml", "--no-default-features", "--features"]
    product = packages("--manifest-path", ROOT / "Cargo.toml", "-p", "camwright_nodes")
    both = packages(*manifest, "dds,zenoh")
    names = {package.split()[0] for package, _ in product}
    added = {package: licence for package, licence in both if package.split()[0] not in names and not package.startswith("zenoh_spike")}
    print(f"\npackages: {len(product)} in the product now; Zenoh adds {len(added)} of new names")
    other = {package: licence for package, licence in added.items() if not re.search("MIT|Apache-2.0|Zlib|Unlicense", licence)}
    print(f"licences that offer neither MIT, Apache-2.0, Zlib nor Unlicense: {other or 'none'}")
    for features in ("dds", "zenoh"):
        target = TARGET / "cost" / features
        shutil.rmtree(target, ignore_errors=True)
        before, start = os.times(), time.monotonic()
        subprocess.run(["cargo", "build", "--release", "-q", "-j2", *manifest, features, "--bin", "zenoh_spike", "--target-dir", target], check=True)
        after = os.times()
        cpu_s = after.children_user - before.children_user + after.children_system - before.children_system
        print(f"clean release build, {features} alone: {time.monotonic() - start:.0f} s, {cpu_s:.0f} s of processor time (load {load()}), "
              f"binary {stripped_mb(target / 'release/zenoh_spike'):.1f} MB stripped", flush=True)
        shutil.rmtree(target)
    print(f"binary with both {stripped_mb(PROGRAM):.1f} MB stripped")
    sources = list((ROOT / "nodes/ros/src").rglob("*.rs"))
    naming = [path for path in sources if re.search("rustdds|ros2_client", path.read_text())]
    print(f"{len(naming)} of {len(sources)} sources of nodes/ros name rustdds or ros2_client")


def stripped_mb(binary):
    stripped = binary.with_name("stripped")
    subprocess.run(["strip", "-o", stripped, binary], check=True)
    return stripped.stat().st_size / 1e6


def main():
    words = sys.argv[1:]
    count = 300 if "--quick" in words else 1000
    sections = [word for word in words if word != "--quick"] or SECTIONS
    known = {name.removesuffix("_section"): run for name, run in globals().items() if name.endswith("_section")}
    unknown = [name for name in sections if name not in known]
    if unknown:
        sys.exit(f"unknown sections {unknown}; known are {sorted(known)}")
    subprocess.run(["cargo", "build", "--release", "-j2", "--manifest-path", HERE / "Cargo.toml", "--bin", "zenoh_spike"], check=True)
    print(f"Linux {os.uname().release}, {os.cpu_count()} cores, load {load()}", flush=True)
    for name in sections:
        with tempfile.TemporaryDirectory() as folder:
            try:
                known[name](folder, count)
            except (RuntimeError, subprocess.CalledProcessError) as error:
                check(f"section {name}", False, str(error))
    print(f"load at the end {load()}; {len(failed)} checks failed")
    sys.exit(1 if failed else 0)


main()
