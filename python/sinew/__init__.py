"""Running Sinew robots from Python: topics read in place, parameters, messages and images published.

    import sinew
    with sinew.attach("quad") as robot:
        frame = robot.topic("camera.raw").wait()      # None after 200 ms without one
        print(frame["width"], frame.pixels.mean(), frame.valid)
        robot.topic("operator.link").publish(quality=1.0)

docs/clients.md has more. Pure Python on libsinew_client; numpy is used when it is there: then arrays are views of the
robot's memory, without a copy.
"""

import ctypes
import json
import struct
import sys
from collections import namedtuple

from . import _library

try:
    import numpy
except ImportError:  # the package works without
    numpy = None

__all__ = ["Error", "Closed", "Busy", "NotFound", "Overwritten", "RunningRobot", "Field", "Message", "Topic", "Robot",
           "attach", "robots"]

_lib = _library.load()
_KINDS = "bBhHiIqQfd"  # of struct, in the order of SINEW_I8, ...
_DTYPES = ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8")
_ORDER = "<" if sys.byteorder == "little" else ">"  # the robot's memory is in this machine's order
_CHANNELS = {"mono8": 1, "rgb8": 3, "bgr8": 3, "yuyv": 2}

RunningRobot = namedtuple("RunningRobot", "name pid")
Field = namedtuple("Field", "name unit doc names kind offset count is_array")


class Error(Exception):
    """A failure, with its reason in words; `code` is "not_found", "bad_argument", ..."""

    def __init__(self, code, why):
        super().__init__(why)
        self.code = code


class Closed(Error):
    """The robot ended, or closed the connection."""


class Busy(Error):
    """The robot has no room now: try again."""


class NotFound(Error):
    """There is no such robot, topic or parameter."""


class Overwritten(Error):
    """The message was read too late: the robot has used its place again."""


_ERRORS = {_library.CLOSED: Closed, _library.BUSY: Busy, _library.NOT_FOUND: NotFound, _library.OVERWRITTEN: Overwritten}


def _check(code):
    if code != _library.OK:
        raise _ERRORS.get(code, Error)(_lib.sinew_code_name(code).decode(), _lib.sinew_last_error().decode(errors="replace"))


def robots():
    """The robots of this machine and user that run now."""
    everyone = ctypes.c_void_p()
    _check(_lib.sinew_robots_list(ctypes.byref(everyone)))
    try:
        return [RunningRobot(_lib.sinew_robots_name(everyone, i).decode(), _lib.sinew_robots_pid(everyone, i))
                for i in range(_lib.sinew_robots_count(everyone))]
    finally:
        _lib.sinew_robots_free(everyone)


def attach(name=""):
    """The running robot of this name, or the only one that runs."""
    return Robot(name)


class _Handle:
    """Detaches when neither the robot nor a view of its memory needs it any more."""

    def __init__(self, name):
        self.value = ctypes.c_void_p()
        _check(_lib.sinew_attach(name.encode(), ctypes.byref(self.value)))

    def __del__(self):
        if self.value:
            _lib.sinew_detach(self.value)


def _view(address, count, owner):
    """`count` bytes at `address`, as long as somebody has the view; `owner` lives as long."""
    memory = (ctypes.c_ubyte * count).from_address(address)
    memory.owner = owner
    return memoryview(memory).cast("B")


class Robot:
    """A connection to a running robot. One thread at a time uses it."""

    def __init__(self, name=""):
        self._own = _Handle(name)
        self._topics = {}
        for i in range(_lib.sinew_topic_count(self._handle)):
            topic = Topic(self, i)
            self._topics[topic.name] = topic

    @property
    def _handle(self):
        if self._own is None:
            raise Closed("closed", "this connection was closed")
        return self._own.value

    def close(self):
        """Ends the connection. Messages and arrays that you still have stay readable, and no longer change."""
        self._own = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    @property
    def name(self):
        return _lib.sinew_name(self._handle).decode()

    @property
    def pid(self):
        return _lib.sinew_pid(self._handle)

    @property
    def topics(self):
        """All topics by name."""
        return dict(self._topics)

    def topic(self, name):
        if name not in self._topics:
            _check(_lib.sinew_topic_find(self._handle, name.encode(), ctypes.byref(ctypes.c_uint32())))
        return self._topics[name]

    def now_ns(self):
        """The robot's clock, as `stamp_ns` of messages."""
        now = ctypes.c_int64()
        _check(_lib.sinew_now(self._handle, ctypes.byref(now), None))
        return now.value

    def clock_offset_ns(self):
        """What to add to time.monotonic_ns() to get the robot's clock, as measured now."""
        now, offset = ctypes.c_int64(), ctypes.c_int64()
        _check(_lib.sinew_now(self._handle, ctypes.byref(now), ctypes.byref(offset)))
        return offset.value

    def get(self, module, param):
        """The value of a parameter."""
        value = _library.Value()
        _check(_lib.sinew_param_get(self._handle, module.encode(), param.encode(), ctypes.byref(value)))
        return {_library.BOOL: lambda: bool(value.boolean), _library.INTEGER: lambda: value.integer,
                _library.NUMBER: lambda: value.number, _library.TEXT: lambda: value.text.decode()}[value.kind]()

    def set(self, module, param, value):
        """Sets a parameter; returns when the module's thread has taken it."""
        if isinstance(value, bool):
            c = _library.Value(kind=_library.BOOL, boolean=value)
        elif isinstance(value, int):
            c = _library.Value(kind=_library.INTEGER, integer=value)
        elif isinstance(value, str):
            c = _library.Value(kind=_library.TEXT, text=value.encode())
        else:
            c = _library.Value(kind=_library.NUMBER, number=float(value))
        _check(_lib.sinew_param_set(self._handle, module.encode(), param.encode(), ctypes.byref(c)))

    def request(self, name, **arguments):
        """Any request of docs/robot-socket.md; the reply as a dict. Refusals raise Error."""
        reply = ctypes.c_char_p()
        _check(_lib.sinew_request(self._handle, name.encode(), json.dumps(arguments).encode(), ctypes.byref(reply)))
        return json.loads(reply.value)


class Topic:
    """One topic of a robot."""

    def __init__(self, robot, index):
        self._robot, self._index = robot, index
        about = _library.Topic()
        _check(_lib.sinew_topic_at(robot._handle, index, ctypes.byref(about)))
        self.name, self.type = about.name.decode(), about.type.decode()
        self.message_bytes, self.bulk_bytes, self.keep = about.message_bytes, about.bulk_bytes, about.keep
        self.rate_hz, self.is_external = about.rate_hz, bool(about.is_external)
        self.wakes_outsiders = bool(about.wakes_outsiders)
        self.fields = {}
        for i in range(about.field_count):
            f = _library.Field()
            _check(_lib.sinew_field_at(robot._handle, index, i, ctypes.byref(f)))
            names = json.loads(f.names) if f.names else {}
            self.fields[f.name.decode()] = Field(f.name.decode(), f.unit.decode(), f.doc.decode(), names,
                                                 _KINDS[f.kind], f.offset, f.count, bool(f.is_array))
        self._dtype = None

    @property
    def dtype(self):
        """A numpy dtype with the fields at their offsets."""
        if self._dtype is None:
            fields = self.fields.values()
            self._dtype = numpy.dtype({
                "names": [f.name for f in fields],
                "formats": [(_ORDER + _DTYPES[_KINDS.index(f.kind)], (f.count,)) if f.is_array
                            else _ORDER + _DTYPES[_KINDS.index(f.kind)] for f in fields],
                "offsets": [f.offset for f in fields], "itemsize": self.message_bytes})
        return self._dtype

    def latest(self):
        """The newest message; None before the first."""
        try:
            return self._get(_lib.sinew_latest)
        except NotFound:
            return None

    def wait(self, timeout_s=0.2):
        """The newest message as soon as there is one that wait() and next() have not given yet; None after the time."""
        return self._wait(_lib.sinew_wait, timeout_s)

    def next(self, timeout_s=0.2):
        """The message after the last one; None after the time. `missed` counts those that were gone."""
        return self._wait(_lib.sinew_next, timeout_s)

    def __iter__(self):
        """Messages one after the other, until the robot ends."""
        while True:
            try:
                message = self.next()
            except Closed:
                return
            if message is not None:
                yield message

    def wake_at_once(self, on=True):
        """wait() and next() are woken by the publishing thread itself, if the robot file allows it."""
        _check(_lib.sinew_wake_at_once(self._robot._handle, self._index, int(on)))

    def _get(self, function, *more):
        c = _library.Message()
        _check(function(self._robot._handle, self._index, *more, ctypes.byref(c)))
        return Message(self, self._robot._own, c)

    def _wait(self, function, timeout_s):
        try:
            return self._get(function, int(max(timeout_s, 0) * 1e9))
        except Error as e:
            if e.code == "timeout":
                return None
            raise

    def publish(self, values=None, *, pixels=None, format=None, stamp_ns=0, wait=True, **more):
        """Publishes one message to a topic with writer = "external".

        Fields by name, as a dict or as keywords; others are zero. `pixels`: an array (height, width[, channels]) of
        bytes, with `format` "mono8", "rgb8", "bgr8" or "yuyv" (two channels); width, height and stride follow from it.
        `stamp_ns`: when it was measured, by robot.now_ns(). wait=False: returns when the robot has accepted it."""
        handle = self._robot._handle
        message, bulk, room = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_size_t()
        _check(_lib.sinew_loan(handle, self._index, ctypes.byref(message), ctypes.byref(bulk), ctypes.byref(room)))
        fields = {**(values or {}), **more}
        used = 0
        if pixels is not None:
            header, used = self._put_pixels(pixels, format, bulk.value, room.value)
            fields = {**header, **fields}
        place = _view(message.value, self.message_bytes, self._robot._own)
        for name, value in fields.items():
            self._put(place, name, value)
        _check(_lib.sinew_send(handle, used, stamp_ns, 0 if wait else _library.NO_WAIT))

    def _put(self, place, name, value):
        if name not in self.fields:
            raise NotFound("not_found", f"{self.type} has no field {name}: {', '.join(self.fields)}")
        f = self.fields[name]
        if isinstance(value, str):
            value = f.names[value]
        values = list(value) if f.is_array else [value]
        if f.kind not in "fd":
            values = [int(v) for v in values]
        if len(values) != f.count:
            raise Error("bad_argument", f"{name}: {len(values)} values, of {f.count}")
        struct.pack_into(f"={f.count}{f.kind}", place, f.offset, *values)

    def _put_pixels(self, pixels, format, address, room):
        shape = pixels.shape if hasattr(pixels, "shape") else memoryview(pixels).shape
        channels = 1 if len(shape) == 2 else shape[2]
        if format is None:
            format = {1: "mono8", 2: "yuyv", 3: "rgb8"}.get(channels)
        if _CHANNELS.get(format) != channels or len(shape) not in (2, 3):
            raise Error("bad_argument", f"pixels of shape {tuple(shape)} are not {format}")
        size = shape[0] * shape[1] * channels
        if size > room:
            raise Error("bad_argument", f"{size} bytes of pixels: {self.name} has room for {room}")
        place = _view(address, room, self._robot._own)
        if numpy is not None:
            numpy.frombuffer(place, numpy.uint8, size).reshape(shape)[...] = numpy.asarray(pixels)
        else:
            place[:size] = memoryview(pixels).cast("B")
        return {"width": shape[1], "height": shape[0], "stride": shape[1] * channels,
                "format": self.fields["format"].names[format]}, size


class Message:
    """One message, read where the robot wrote it. The robot uses the place again after `topic.keep` further messages:
    ask `valid` after you have read, or work on a copy()."""

    def __init__(self, topic, owner, c, copied=False):
        self.topic, self._owner, self._c, self._copied = topic, owner, c, copied
        self.sequence, self.missed = c.sequence, c.missed
        self.stamp_ns, self.published_ns = c.stamp_ns, c.published_ns

    @property
    def valid(self):
        """True: all that was read until now is what the robot published."""
        return self._copied or bool(_lib.sinew_still_valid(self._owner.value, ctypes.byref(self._c)))

    def copy(self):
        """A message in memory of its own. Raises Overwritten."""
        if self._copied:
            return self
        size = self._c.message_bytes + self._c.bulk_bytes
        own = (ctypes.c_ubyte * size)()
        _check(_lib.sinew_copy(self._owner.value, ctypes.byref(self._c), own, size))
        c = _library.Message.from_buffer_copy(self._c)
        c.data = ctypes.addressof(own)
        c.bulk = c.data + c.message_bytes if self._c.bulk else None
        return Message(self.topic, own, c, copied=True)

    @property
    def data(self):
        """The message's bytes, read only."""
        return _view(self._c.data, self._c.message_bytes, self._owner).toreadonly()

    @property
    def bulk(self):
        """The bytes of the pixels, read only; empty when there are none."""
        if not self._c.bulk:
            return memoryview(b"")
        return _view(self._c.bulk, self._c.bulk_bytes, self._owner).toreadonly()

    def __getitem__(self, name):
        """A field by name, "gyro_radps.x": a number; an array as numpy array, or as tuple without numpy."""
        f = self.topic.fields[name]
        if f.is_array and numpy is not None:
            return numpy.frombuffer(self.data, _ORDER + _DTYPES[_KINDS.index(f.kind)], f.count, f.offset)
        values = struct.unpack_from(f"={f.count}{f.kind}", self.data, f.offset)
        return values if f.is_array else values[0]

    @property
    def array(self):
        """All fields as a numpy array of one record, without a copy."""
        return numpy.frombuffer(self.data, self.topic.dtype, 1)

    @property
    def pixels(self):
        """Of an Image: a numpy view without a copy, (height, width) or (height, width, channels)."""
        names = {number: name for name, number in self.topic.fields["format"].names.items()}
        channels = _CHANNELS.get(names.get(self["format"]), 0)
        height, width, stride = self["height"], self["width"], self["stride"]
        if channels == 0 or stride < width * channels or stride * height > self._c.bulk_bytes:
            raise Overwritten("overwritten", "the image was overwritten while its header was read, or has no pixels")
        if stride * height == 0:
            return numpy.zeros((0, 0), numpy.uint8)
        rows = numpy.frombuffer(self.bulk, numpy.uint8, stride * height).reshape(height, stride)[:, :width * channels]
        return rows if channels == 1 else rows.reshape(height, width, channels)

    def to_dict(self):
        """All fields by name."""
        return {name: self[name] for name in self.topic.fields}

    def __repr__(self):
        return f"<{self.topic.name} {self.topic.type} sequence={self.sequence} stamp_ns={self.stamp_ns}>"
