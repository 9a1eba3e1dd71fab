# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""An OPC UA client that takes orders: one JSON object a line each way.

    opcua_client.py URL

Paths are browse names without namespaces, from the first machine in the folder Machines.
"""

import asyncio
import json
import logging
import sys

from asyncua import Client, ua

QUEUE = 1000
PERIOD_MS = 100


def say(**message):
    print(json.dumps(message), flush=True)


def plain(value):
    """A value as JSON."""
    if isinstance(value, ua.LocalizedText):
        return value.Text
    if isinstance(value, ua.NodeId):
        return value.to_string()
    if isinstance(value, ua.EUInformation):
        return {"unit": value.DisplayName.Text, "id": value.UnitId}
    if isinstance(value, ua.Range):
        return {"low": value.Low, "high": value.High}
    if isinstance(value, ua.EnumValueType):
        return {"value": value.Value, "name": value.DisplayName.Text}
    if isinstance(value, list):
        return [plain(one) for one in value]
    return value


def reading(data):
    value = data.Value.Value if data.Value is not None else None
    time = data.SourceTimestamp
    return {"value": plain(value), "status": ua.status_codes.get_name_and_doc(data.StatusCode.value)[0],
            "time": time.timestamp() if time else None}


class Peer:
    def __init__(self, client):
        self.client = client
        self.nodes = {}
        self.names = {}
        self.subscription = None

    def datachange_notification(self, node, value, data):
        path = self.names[node.nodeid]
        if node == self.nodes.get("Notification/Messages"):
            return  # The server says of the item for events, too, that it waits for a first value.
        say(event="data", path=path, **reading(data.monitored_item.Value))

    def event_notification(self, event):
        fields = event.get_event_props_as_fields_dict()
        say(event="alert", **{name: plain(variant.Value) for name, variant in fields.items()
                              if name in ("Message", "Severity", "SourceName", "ErrorCode", "Retain")})

    def status_change_notification(self, status):
        say(event="status", status=str(status))

    async def walk(self, node, path, tree):
        for child in await node.get_children_descriptions():
            name = f"{path}/{child.BrowseName.Name}" if path else child.BrowseName.Name
            found = self.client.get_node(child.NodeId)
            self.nodes[name] = found
            self.names.setdefault(child.NodeId, name)
            namespaces = self.client_namespaces
            kind = child.TypeDefinition
            tree[name] = {"namespace": namespaces[child.BrowseName.NamespaceIndex], "class": child.NodeClass_.name,
                          "type": [namespaces[kind.NamespaceIndex], kind.Identifier]}
            await self.walk(found, name, tree)

    async def now(self, _):
        """An answer after what has arrived so far; who asks again soon waits a moment for more."""
        await asyncio.sleep(PERIOD_MS / 2000)
        return {}

    async def browse(self, _):
        self.client_namespaces = await self.client.get_namespace_array()
        machinery = self.client_namespaces.index("http://opcfoundation.org/UA/Machinery/")
        machines = await self.client.nodes.objects.get_child([f"{machinery}:Machines"])
        [machine] = await machines.get_children()
        tree = {}
        await self.walk(machine, "", tree)
        return {"namespaces": self.client_namespaces, "machine": (await machine.read_browse_name()).Name, "tree": tree}

    async def subscribe(self, order):
        if self.subscription is None:
            self.subscription = await self.client.create_subscription(PERIOD_MS, self)
        nodes = [self.nodes[path] for path in order["paths"]]
        # Notifications come with the name under which they were asked for.
        self.names.update({node.nodeid: path for node, path in zip(nodes, order["paths"])})
        results = await self.subscription.subscribe_data_change(nodes, queuesize=QUEUE, sampling_interval=0)
        return {"accepted": sum(isinstance(result, int) for result in results)}

    async def alerts(self, _):
        if self.subscription is None:
            self.subscription = await self.client.create_subscription(PERIOD_MS, self)
        tool = self.client_namespaces.index("http://opcfoundation.org/UA/MachineTool/")
        base, condition, alert = ua.NodeId(2041), ua.NodeId(2782), ua.NodeId(39, tool)
        fields = [(base, "Message", 0), (base, "Severity", 0), (base, "SourceName", 0), (condition, "Retain", 0),
                  (alert, "ErrorCode", tool)]
        # Fields by the types that declare them: the server leaves out those that it does not find.
        selected = ua.EventFilter()
        selected.SelectClauses = [
            ua.SimpleAttributeOperand(TypeDefinitionId=kind, BrowsePath=[ua.QualifiedName(name, index)],
                                      AttributeId=ua.AttributeIds.Value) for kind, name, index in fields]
        await self.subscription.subscribe_events(
            self.nodes["Notification/Messages"], evfilter=selected, queuesize=QUEUE)
        return {}

    async def read(self, order):
        data = await self.nodes[order["path"]].read_data_value(raise_on_bad_status=False)
        return reading(data)

    async def enumeration(self, order):
        """Names of the values of an enumerated variable, from its data type."""
        kind = self.client.get_node(await self.nodes[order["path"]].read_data_type())
        [values] = [child for child in await kind.get_properties()]
        return {"name": (await kind.read_browse_name()).Name, "values": plain(await values.read_value())}

    async def write(self, order):
        node = self.nodes[order["path"]]
        attribute = ua.AttributeIds[order.get("attribute", "Value")]
        kind = ua.VariantType[order["type"]]
        try:
            await node.write_attribute(attribute, ua.DataValue(ua.Variant(order["value"], kind)))
        except ua.UaStatusCodeError as error:
            return {"refused": ua.status_codes.get_name_and_doc(error.code)[0]}
        return {"refused": None}


async def main(url):
    # The reader of orders, not the library, says what went wrong.
    logging.disable(logging.CRITICAL)
    loop = asyncio.get_running_loop()
    lines = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(lines), sys.stdin)
    async with Client(url, timeout=60) as client:
        peer = Peer(client)
        say(event="ready")
        while line := await lines.readline():
            order = json.loads(line)
            try:
                say(id=order["id"], ok=True, **await getattr(peer, order["op"])(order))
            except Exception as error:  # noqa: BLE001: every error is an answer
                say(id=order["id"], ok=False, error=f"{type(error).__name__}: {error}")


asyncio.run(main(sys.argv[1]))
