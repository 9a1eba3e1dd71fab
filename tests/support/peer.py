# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""A real ROS 2 node (rclpy, Fast DDS) that the tests steer: one JSON object a line on stdin, answers and events on stdout.

    peer.py NAME [--namespace NS] [--sim-time]

Each command has an `id` and an `op` (the functions `op_*` below); each gets one answer {"id", "ok": true, ...} or {"id", "ok": false,
"error"}. What happens by itself comes as {"event": ...}. End of stdin ends the peer. The tests hold what is expected, not this file.
"""

import argparse
import json
import os
import queue
import sys
import threading
import time

import rclpy
import yaml
from action_msgs.srv import CancelGoal
from plain import from_plain, interface, to_plain
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_dict_from_yaml_file, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy, qos_policy_name_from_kind
from rclpy.qos import qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState
from rclpy.task import Future

# How long a command that waits (for a node, an answer, a goal) may take unless it says so itself.
PATIENCE_S = 60.0


def say(**what):
    print(json.dumps(what, allow_nan=False), flush=True)


def qos(text):
    """"reliable", "best_effort", "latched", each with a depth if wanted: "reliable:1000"."""
    kind, _, depth = (text or "reliable").partition(":")
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=int(depth or 10),
        reliability=ReliabilityPolicy.BEST_EFFORT if kind == "best_effort" else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if kind == "latched" else DurabilityPolicy.VOLATILE,
    )


class Waiting:
    """A command whose answer comes once `look` returns something."""

    def __init__(self, command, look, what):
        self.id, self.look, self.what = command["id"], look, what
        self.deadline = time.monotonic() + command.get("timeout", PATIENCE_S)


class Peer:
    def __init__(self, arguments):
        self.node = rclpy.create_node(
            arguments.name,
            namespace=arguments.namespace,
            parameter_overrides=[Parameter("use_sim_time", value=True)] if arguments.sim_time else [],
        )
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.commands = queue.Queue()
        self.wake = self.node.create_guard_condition(self.work)
        self.waiting = []
        self.publishers, self.subscriptions, self.clients, self.action_clients, self.kept = {}, {}, {}, {}, []
        self.services = {}
        self.goals, self.served_goals = {}, {}
        self.running = True
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        for line in sys.stdin:
            self.commands.put(json.loads(line))
            self.wake.trigger()
        self.commands.put({"op": "quit", "id": 0})
        self.wake.trigger()

    def work(self):
        while not self.commands.empty():
            command = self.commands.get()
            try:
                answer = getattr(self, "op_" + command["op"])(command)
            except Exception as error:  # whatever goes wrong is the test's to judge
                say(id=command["id"], ok=False, error=f"{type(error).__name__}: {error}")
                continue
            if isinstance(answer, Waiting):
                self.waiting.append(answer)
            elif answer is not None:
                say(id=command["id"], ok=True, **answer)

    def look(self):
        for entry in list(self.waiting):
            found = entry.look()
            if found is not None:
                say(id=entry.id, ok=True, **found)
            elif time.monotonic() > entry.deadline:
                say(id=entry.id, ok=False, error=f"timed out waiting for {entry.what}")
            else:
                continue
            self.waiting.remove(entry)

    def spin(self):
        say(event="ready")
        while self.running:
            # Waiting commands look at the graph, which tells nobody when it changes: look every few milliseconds while any waits.
            self.executor.spin_once(timeout_sec=0.01 if self.waiting else 1.0)
            self.look()

    def when_done(self, command, future, answer):
        """Answers the command from the future's result, or gives up after its patience."""
        self.waiting.append(Waiting(command, lambda: answer(future.result()) if future.done() else None, command["op"]))

    # --- topics

    @staticmethod
    def misfit(topic):
        """Tells of an endpoint that asks for more than the other offers."""
        def told(info):
            say(event="incompatible", topic=topic, policy=qos_policy_name_from_kind(info.last_policy_kind))

        return told

    def op_advertise(self, c):
        events = PublisherEventCallbacks(incompatible_qos=self.misfit(c["topic"]))
        self.publishers[c["topic"]] = self.node.create_publisher(
            interface(c["type"]), c["topic"], qos(c.get("qos")), event_callbacks=events)
        return {}

    def op_publish(self, c):
        publisher = self.publishers[c["topic"]]
        publisher.publish(from_plain(publisher.msg_type, c["data"]))
        return {}

    def op_subscribe(self, c):
        counted = {"n": 0}

        def got(message):
            counted["n"] += 1
            if c.get("keep", "all") == "all" or counted["n"] <= c["keep"]:
                say(event="message", topic=c["topic"], n=counted["n"], data=to_plain(message))

        events = SubscriptionEventCallbacks(incompatible_qos=self.misfit(c["topic"]))
        self.subscriptions[c["topic"]] = self.node.create_subscription(
            interface(c["type"]), c["topic"], got, qos(c.get("qos")), event_callbacks=events)
        self.clients[("count", c["topic"])] = counted
        return {}

    def op_received(self, c):
        """How many messages came on a subscribed topic so far; with `at_least`, waits for so many."""
        counted, at_least = self.clients[("count", c["topic"])], c.get("at_least", 0)
        return Waiting(c, lambda: {"n": counted["n"]} if counted["n"] >= at_least else None, f"{at_least} messages on {c['topic']}")

    # --- the graph

    def op_wait_node(self, c):
        wanted = (c["name"], c.get("namespace", "/"))
        return Waiting(c, lambda: {} if wanted in self.node.get_node_names_and_namespaces() else None, f"node {wanted}")

    def op_wait_gone(self, c):
        """Until a node and everything below a prefix of names have left the graph."""
        def look():
            names = [name for name, _ in self.node.get_topic_names_and_types() + self.node.get_service_names_and_types()]
            there = (c["name"], c.get("namespace", "/")) in self.node.get_node_names_and_namespaces()
            return None if there or any(name.startswith(c["prefix"]) for name in names) else {}

        return Waiting(c, look, f"{c['name']} to leave")

    def op_wait_publishers(self, c):
        count = lambda: self.node.count_publishers(c["topic"])
        return Waiting(c, lambda: {} if count() >= c.get("n", 1) else None, f"publishers of {c['topic']}")

    def op_wait_subscribers(self, c):
        count = lambda: self.node.count_subscribers(c["topic"])
        return Waiting(c, lambda: {} if count() >= c.get("n", 1) else None, f"subscribers of {c['topic']}")

    def op_wait_service(self, c):
        there = lambda: any(name == c["service"] for name, _ in self.node.get_service_names_and_types())
        return Waiting(c, lambda: {} if there() else None, f"service {c['service']}")

    def op_wait_matched(self, c):
        """Waits until the peer's own publisher has matched so many subscriptions."""
        publisher = self.publishers[c["topic"]]
        return Waiting(c, lambda: {} if publisher.get_subscription_count() >= c.get("n", 1) else None, f"a match on {c['topic']}")

    def op_wait_subscribed(self, c):
        """Waits until the peer's own subscription has matched so many publishers: each side finds the other at its own time."""
        subscription = self.subscriptions[c["topic"]]
        return Waiting(c, lambda: {} if subscription.get_publisher_count() >= c.get("n", 1) else None, f"a match on {c['topic']}")

    def op_graph(self, _):
        return {
            "nodes": [(ns.rstrip("/") + "/" + name) for name, ns in self.node.get_node_names_and_namespaces()],
            "topics": dict(self.node.get_topic_names_and_types()),
            "services": dict(self.node.get_service_names_and_types()),
        }

    def op_endpoints(self, c):
        """The endpoints of a topic, once every one is known by its node: an endpoint and the list of a node's endpoints travel apart."""
        def plain(info):
            return {
                "node": info.node_namespace.rstrip("/") + "/" + info.node_name,
                "type": info.topic_type,
                "hash": str(info.topic_type_hash),
                "reliability": info.qos_profile.reliability.name,
                "durability": info.qos_profile.durability.name,
            }

        def look():
            found = {
                "publishers": self.node.get_publishers_info_by_topic(c["topic"]),
                "subscribers": self.node.get_subscriptions_info_by_topic(c["topic"]),
            }
            if any(info.node_name.startswith("_") for infos in found.values() for info in infos):
                return None
            return {kind: [plain(info) for info in infos] for kind, infos in found.items()}

        return Waiting(c, look, f"the nodes of the endpoints of {c['topic']}")

    # --- services

    def op_call(self, c):
        key = ("service", c["service"])
        kind = interface(c["type"])
        if key not in self.clients:
            self.clients[key] = self.node.create_client(kind, c["service"])
        client, state = self.clients[key], {}
        request = from_plain(kind.Request, c.get("request", {}))

        def look():
            if "future" not in state:
                if client.service_is_ready():
                    state["future"] = client.call_async(request)
                return None
            return {"response": to_plain(state["future"].result())} if state["future"].done() else None

        return Waiting(c, look, f"service {c['service']}")

    def op_serve(self, c):
        """Offers a service that answers with the fields of `response`; each request is told as an event."""
        kind = interface(c["type"])

        def answer(request, _):
            say(event="request", service=c["service"], data=to_plain(request))
            return from_plain(kind.Response, c.get("response", {}))

        self.services[c["service"]] = self.node.create_service(kind, c["service"], answer)
        return {}

    def op_introspect(self, c):
        """Publishes events of a service that is offered or, with its type, of the client of `op_call`: off, metadata or contents."""
        key = ("service", c["service"])
        if "type" in c and key not in self.clients:
            self.clients[key] = self.node.create_client(interface(c["type"]), c["service"])
        endpoint = self.clients[key] if "type" in c else self.services[c["service"]]
        state = getattr(ServiceIntrospectionState, c["state"].upper())
        endpoint.configure_introspection(self.node.get_clock(), qos_profile_system_default, state)
        return {}

    def op_dump(self, c):
        """The YAML that `ros2 param dump` writes for a node."""
        state = {}

        def call(service, kind, **request):
            if service not in state:
                client = self.node.create_client(kind, f"{c['node']}/{service}")
                state[service] = [client, None]
            client, future = state[service]
            if future is None:
                if client.service_is_ready():
                    state[service][1] = client.call_async(kind.Request(**request))
                return None
            return future.result() if future.done() else None

        def look():
            listed = call("list_parameters", ListParameters)
            read = listed and call("get_parameters", GetParameters, names=sorted(listed.result.names))
            if read is None:
                return None
            tree = {}
            for name, value in zip(sorted(listed.result.names), read.values):
                *groups, leaf = name.split(".")
                place = tree
                for group in groups:
                    place = place.setdefault(group, {})
                place[leaf] = parameter_value_to_python(value)
            return {"yaml": yaml.dump({c["node"]: {"ros__parameters": tree}}, default_flow_style=False)}

        return Waiting(c, look, f"the parameters of {c['node']}")

    def op_load(self, c):
        """What `ros2 param load` does with a file: the client of rclpy that it is made of, and the outcome for each parameter."""
        state = {}

        def look():
            if "future" not in state:
                client = state.setdefault("client", AsyncParameterClient(self.node, c["node"]))
                if client.services_are_ready():
                    wanted = parameter_dict_from_yaml_file(c["file"], target_nodes=[c["node"]])
                    state["names"] = [parameter.name for parameter in wanted.values()]
                    state["future"] = client.load_parameter_file(c["file"])
                return None
            if not state["future"].done():
                return None
            results = state["future"].result().results
            return {"reasons": {name: "" if r.successful else r.reason for name, r in zip(state["names"], results)}}

        return Waiting(c, look, f"the parameters of {c['node']} to be loaded")

    def burst(self, c, client, is_ready, send, sort):
        """Sends `n` requests in one loop without reading an answer; then reads until all are there or `patience` is over."""
        state = {}

        def look():
            if "futures" not in state:
                if is_ready():
                    state["begun"] = time.monotonic()
                    state["futures"] = [send() for _ in range(c["n"])]
                    state["sent_s"] = time.monotonic() - state["begun"]
                return None
            answered = [future for future in state["futures"] if future.done()]
            taken_s = time.monotonic() - state["begun"]
            if len(answered) < c["n"] and taken_s < c.get("patience", 10.0):
                return None
            kinds = [sort(future.result()) for future in answered]
            counts = {kind: kinds.count(kind) for kind in sorted(set(kinds))}
            return {"answered": len(answered), "kinds": counts, "sent_s": state["sent_s"], "taken_s": taken_s}

        return Waiting(c, look, f"{c['n']} answers")

    def op_burst_of_goals(self, c):
        kind = interface(c["type"])
        client = self.action_clients.setdefault(c["action"], None) or ActionClient(self.node, kind, c["action"])
        self.action_clients[c["action"]] = client
        goal = from_plain(kind.Goal, c.get("goal", {}))
        sort = lambda handle: "accepted" if handle.accepted else "rejected"
        return self.burst(c, client, client.server_is_ready, lambda: client.send_goal_async(goal), sort)

    def op_burst_of_calls(self, c):
        kind = interface(c["type"])
        client = self.node.create_client(kind, c["service"])
        request = from_plain(kind.Request, c.get("request", {}))
        sort = lambda response: str(to_plain(response).get("success", ""))
        return self.burst(c, client, client.service_is_ready, lambda: client.call_async(request), sort)

    # --- actions, as a client

    def op_send_goal(self, c):
        kind = interface(c["type"])
        if c["action"] not in self.action_clients:
            self.action_clients[c["action"]] = ActionClient(self.node, kind, c["action"])
        client, state = self.action_clients[c["action"]], {}

        def feedback(message):
            goal = bytes(message.goal_id.uuid).hex()
            say(event="feedback", goal=goal, data=to_plain(message.feedback))

        def look():
            if "future" not in state:
                if client.server_is_ready():
                    state["future"] = client.send_goal_async(from_plain(kind.Goal, c.get("goal", {})), feedback)
                return None
            if not state["future"].done():
                return None
            handle = state["future"].result()
            goal = bytes(handle.goal_id.uuid).hex()
            if handle.accepted:
                self.goals[goal] = (client, handle)
            return {"accepted": handle.accepted, "goal": goal}

        return Waiting(c, look, f"action {c['action']}")

    def op_result(self, c):
        _, handle = self.goals[c["goal"]]
        self.when_done(c, handle.get_result_async(), lambda r: {"status": r.status, "result": to_plain(r.result)})

    def op_cancel(self, c):
        _, handle = self.goals[c["goal"]]
        self.when_done(c, handle.cancel_goal_async(), self.cancel_answer)

    def op_cancel_request(self, c):
        """A cancel request as it stands in action_msgs, for all goals or those before a time."""
        key = ("cancel", c["action"])
        if key not in self.clients:
            self.clients[key] = self.node.create_client(CancelGoal, c["action"] + "/_action/cancel_goal")
        client, state = self.clients[key], {}

        def look():
            if "future" not in state:
                if client.service_is_ready():
                    state["future"] = client.call_async(from_plain(CancelGoal.Request, c.get("request", {})))
                return None
            return self.cancel_answer(state["future"].result()) if state["future"].done() else None

        return Waiting(c, look, f"cancel service of {c['action']}")

    @staticmethod
    def cancel_answer(response):
        return {
            "return_code": response.return_code,
            "goals": [bytes(info.goal_id.uuid).hex() for info in response.goals_canceling],
        }

    # --- actions, as a server

    def op_serve_action(self, c):
        """Offers an action. Every goal gets the `feedback` messages at once; it then ends with `result`, or, with `hold`, only when it
        is cancelled, or at once as aborted with `abort`. `reject` refuses every goal."""
        kind = interface(c["type"])

        async def execute(handle):
            goal = bytes(handle.goal_id.uuid).hex()
            for feedback in c.get("feedback", []):
                handle.publish_feedback(from_plain(kind.Feedback, feedback))
            if c.get("abort"):
                handle.abort()
            elif c.get("hold"):
                self.served_goals[goal] = cancelled = Future(executor=self.executor)
                await cancelled
                handle.canceled()
            else:
                handle.succeed()
            return from_plain(kind.Result, c.get("result", {}))

        def goal_asked(goal):
            say(event="goal", action=c["action"], data=to_plain(goal))
            return GoalResponse.REJECT if c.get("reject") else GoalResponse.ACCEPT

        def cancel_asked(handle):
            goal = bytes(handle.goal_id.uuid).hex()
            say(event="cancel", action=c["action"], goal=goal)
            # The goal changes to cancelling only after this returns, so its end has to wait for the next round of the executor.
            future = self.served_goals[goal]
            self.executor.create_task(lambda: future.set_result(None))
            return CancelResponse.ACCEPT

        self.kept.append(ActionServer(self.node, kind, c["action"], execute, goal_callback=goal_asked, cancel_callback=cancel_asked))
        return {}

    # --- the peer itself

    def op_now(self, c):
        """The node's clock (ns); with `at_least`, waits for it."""
        def look():
            now = self.node.get_clock().now().nanoseconds
            return {"now": now} if now >= c.get("at_least", 0) else None

        return Waiting(c, look, "the clock")

    def op_quit(self, c):
        self.running = False
        return {}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("name")
    parser.add_argument("--namespace", default="/")
    parser.add_argument("--sim-time", action="store_true")
    rclpy.init(args=[])
    peer = Peer(parser.parse_args())
    peer.spin()
    sys.stdout.flush()
    # rclpy's teardown takes seconds and has crashed; nobody waits for what it would tidy.
    os._exit(0)


main()
