"""The C interface of libsinew_client, as sinew_client.h declares it."""

import ctypes
import os
from ctypes import POINTER, c_char_p, c_double, c_int, c_int32, c_int64, c_size_t, c_uint, c_uint32, c_void_p

ABI = 1
OK, NOT_FOUND, BUSY, DENIED, NOT_SUPPORTED, BAD_ARGUMENT, BAD_DATA, CLOSED, TIMEOUT, OUT_OF_MEMORY, IO, OVERWRITTEN = range(12)
BOOL, INTEGER, NUMBER, TEXT = range(4)
NO_WAIT = 1


class Topic(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("type", c_char_p), ("message_bytes", c_uint32), ("bulk_bytes", c_uint32),
                ("field_count", c_uint32), ("keep", c_uint32), ("is_external", c_int32), ("wakes_outsiders", c_int32),
                ("rate_hz", c_double)]


class Field(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("unit", c_char_p), ("doc", c_char_p), ("names", c_char_p), ("kind", c_uint32),
                ("offset", c_uint32), ("count", c_uint32), ("is_array", c_uint32)]


class Message(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("bulk", c_void_p), ("message_bytes", c_uint32), ("bulk_bytes", c_uint32),
                ("topic", c_uint32), ("sequence", c_uint32), ("stamp_ns", c_int64), ("published_ns", c_int64),
                ("missed", c_uint32), ("reserved", c_uint32 * 5)]


class Value(ctypes.Structure):
    _fields_ = [("kind", c_int32), ("boolean", c_int32), ("integer", c_int64), ("number", c_double),
                ("text", c_char_p)]


# Name: (result, arguments). Results of c_int are codes, except where the name says otherwise.
FUNCTIONS = {
    "sinew_client_abi": (c_int, []),
    "sinew_code_name": (c_char_p, [c_int]),
    "sinew_last_error": (c_char_p, []),
    "sinew_robots_list": (c_int, [POINTER(c_void_p)]),
    "sinew_robots_count": (c_size_t, [c_void_p]),
    "sinew_robots_name": (c_char_p, [c_void_p, c_size_t]),
    "sinew_robots_pid": (c_int, [c_void_p, c_size_t]),
    "sinew_robots_free": (None, [c_void_p]),
    "sinew_attach": (c_int, [c_char_p, POINTER(c_void_p)]),
    "sinew_detach": (None, [c_void_p]),
    "sinew_name": (c_char_p, [c_void_p]),
    "sinew_pid": (c_int, [c_void_p]),
    "sinew_now": (c_int, [c_void_p, POINTER(c_int64), POINTER(c_int64)]),
    "sinew_topic_count": (c_size_t, [c_void_p]),
    "sinew_topic_at": (c_int, [c_void_p, c_uint32, POINTER(Topic)]),
    "sinew_topic_find": (c_int, [c_void_p, c_char_p, POINTER(c_uint32)]),
    "sinew_field_at": (c_int, [c_void_p, c_uint32, c_uint32, POINTER(Field)]),
    "sinew_field_find": (c_int, [c_void_p, c_uint32, c_char_p, POINTER(Field)]),
    "sinew_latest": (c_int, [c_void_p, c_uint32, POINTER(Message)]),
    "sinew_wait": (c_int, [c_void_p, c_uint32, c_int64, POINTER(Message)]),
    "sinew_next": (c_int, [c_void_p, c_uint32, c_int64, POINTER(Message)]),
    "sinew_wake_at_once": (c_int, [c_void_p, c_uint32, c_int]),
    "sinew_still_valid": (c_int, [c_void_p, POINTER(Message)]),
    "sinew_copy": (c_int, [c_void_p, POINTER(Message), c_void_p, c_size_t]),
    "sinew_param_get": (c_int, [c_void_p, c_char_p, c_char_p, POINTER(Value)]),
    "sinew_param_set": (c_int, [c_void_p, c_char_p, c_char_p, POINTER(Value)]),
    "sinew_request": (c_int, [c_void_p, c_char_p, c_char_p, POINTER(c_char_p)]),
    "sinew_loan": (c_int, [c_void_p, c_uint32, POINTER(c_void_p), POINTER(c_void_p), POINTER(c_size_t)]),
    "sinew_send": (c_int, [c_void_p, c_size_t, c_int64, c_uint]),
    "sinew_publish": (c_int, [c_void_p, c_uint32, c_void_p, c_size_t, c_void_p, c_size_t, c_int64, c_uint]),
}


def load():
    """$SINEW_CLIENT_LIBRARY, else the installed library."""
    library = ctypes.CDLL(os.environ.get("SINEW_CLIENT_LIBRARY") or "libsinew_client.so.1")
    for name, (result, arguments) in FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    if library.sinew_client_abi() < ABI:
        raise ImportError(f"libsinew_client is older than this package: {library.sinew_client_abi()}, needs {ABI}")
    return library
