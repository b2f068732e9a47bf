/* Looks at running Sinew robots from another program and steers them: topics read in place, parameters, messages and
 * images published. Plain C99. docs/clients.md has the same for Python and Octave.
 *
 * Errors:  functions that return int answer SINEW_OK (0) or one of the codes below; sinew_last_error() then has the
 *          reason in words. What a function writes through pointers is defined only after SINEW_OK.
 * Thread:  a robot handle belongs to one thread at a time. sinew_still_valid(), sinew_copy() and sinew_latest() may be
 *          called by any thread as long as no other detaches. A process may hold four handles of one robot.
 * Texts:   UTF-8, ending with a zero. Texts that a function answers belong to the handle; each says how long they live.
 * Times:   int64 nanoseconds. Stamps are on the robot's clock: sinew_now().
 * ABI:     functions and constants are only added, structures never change; sinew_client_abi() counts the additions.
 */
#ifndef SINEW_CLIENT_H
#define SINEW_CLIENT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define SINEW_API __attribute__((visibility("default")))
#else
#define SINEW_API
#endif

#define SINEW_CLIENT_ABI 1
#define SINEW_DEFAULT_TIMEOUT_NS 200000000 /* 200 ms: six frames of a camera with 30 Hz */

enum {
  SINEW_OK = 0,
  SINEW_NOT_FOUND = 1,     /* no such robot, topic, parameter; no message yet */
  SINEW_BUSY = 2,          /* the robot has no room now: try again */
  SINEW_DENIED = 3,        /* another user's robot; what the guardian refuses */
  SINEW_NOT_SUPPORTED = 4, /* this robot cannot do it */
  SINEW_BAD_ARGUMENT = 5,  /* refused before anything happened */
  SINEW_BAD_DATA = 6,      /* the robot said what its protocol does not allow */
  SINEW_CLOSED = 7,        /* the robot ended, or closed the connection */
  SINEW_TIMEOUT = 8,
  SINEW_OUT_OF_MEMORY = 9,
  SINEW_IO = 10,
  SINEW_OVERWRITTEN = 11 /* the message is gone: it was read too late */
};

/* The SINEW_CLIENT_ABI of the library that is loaded: at least the one that the program was compiled with. */
SINEW_API int sinew_client_abi(void);
/* "not_found"; never NULL. */
SINEW_API const char *sinew_code_name(int code);
/* The calling thread's last failure in words, until its next failure; "" before the first. */
SINEW_API const char *sinew_last_error(void);

/* ---- Robots of this machine and user */

typedef struct sinew_robots sinew_robots;
/* Those that run now, in order of name; free the list with sinew_robots_free(). */
SINEW_API int sinew_robots_list(sinew_robots **list);
SINEW_API size_t sinew_robots_count(const sinew_robots *list);
/* NULL and 0 past the end. The name lives as long as the list. */
SINEW_API const char *sinew_robots_name(const sinew_robots *list, size_t index);
SINEW_API int sinew_robots_pid(const sinew_robots *list, size_t index);
SINEW_API void sinew_robots_free(sinew_robots *list);

/* A connection to one robot, with its topics mapped into this process. */
typedef struct sinew_robot sinew_robot;
/* name NULL or "": the only robot that runs. Errors: not_found; bad_argument: several run; closed: the robot has no
 * place for one more program; not_supported: its topics are not in shared memory, or it speaks another version. */
SINEW_API int sinew_attach(const char *name, sinew_robot **robot);
/* All messages of this handle end with it. NULL: nothing happens. */
SINEW_API void sinew_detach(sinew_robot *robot);
SINEW_API const char *sinew_name(const sinew_robot *robot);
SINEW_API int sinew_pid(const sinew_robot *robot);
/* The robot's clock. *offset_ns, if it is not NULL, is what to add to CLOCK_MONOTONIC of this machine to get it, as
 * measured now: half of the request's duration is its uncertainty. The offset of a robot in real time (without
 * --rate) is 0. A simulated robot's clock goes by leaps, so ask again for each stamp. */
SINEW_API int sinew_now(sinew_robot *robot, int64_t *now_ns, int64_t *offset_ns);

/* ---- Topics */

typedef struct sinew_topic {
  const char *name, *type;
  uint32_t message_bytes; /* of the message's structure */
  uint32_t bulk_bytes;    /* room for pixels behind it; 0: none */
  uint32_t field_count;   /* for sinew_field_at() */
  uint32_t keep;          /* newest messages that can be read */
  int32_t is_external;    /* not 0: takes messages of sinew_publish() */
  int32_t wakes_outsiders; /* not 0: sinew_wake_at_once() is possible */
  double rate_hz;         /* planned; 0: not known */
} sinew_topic;

enum { SINEW_I8, SINEW_U8, SINEW_I16, SINEW_U16, SINEW_I32, SINEW_U32, SINEW_I64, SINEW_U64, SINEW_F32, SINEW_F64 };

/* One number of a message, or an array of numbers without gaps, in this machine's order of bytes. */
typedef struct sinew_field {
  const char *name;   /* "range_m", "gyro_radps.x", "detections[3].x_px" */
  const char *unit;   /* "m/s", "1", "ns"; "enum": a choice, see names */
  const char *doc;    /* "" when there is none */
  const char *names;  /* JSON: {"armed": 2, ...} of a choice or of bits; "" when there is none */
  uint32_t kind;      /* SINEW_F64, ... */
  uint32_t offset;    /* from the beginning of the message */
  uint32_t count;     /* 1, or that of the array */
  uint32_t is_array;
} sinew_field;

/* All texts live as long as the handle. Topics have numbers from 0 to count - 1. */
SINEW_API size_t sinew_topic_count(const sinew_robot *robot);
SINEW_API int sinew_topic_at(const sinew_robot *robot, uint32_t topic, sinew_topic *about);
SINEW_API int sinew_topic_find(const sinew_robot *robot, const char *name, uint32_t *topic);
SINEW_API int sinew_field_at(const sinew_robot *robot, uint32_t topic, uint32_t index, sinew_field *about);
SINEW_API int sinew_field_find(const sinew_robot *robot, uint32_t topic, const char *name, sinew_field *about);

/* ---- Messages, read where the robot wrote them */

/* A view into the robot's memory, which this process cannot write. The robot never waits for a reader and uses the
 * place again after `keep` further messages: take what you need, then ask sinew_still_valid(). Until that says so, all
 * that you read may be half of one message and half of another. A camera with keep = 5 at 30 Hz leaves 130 ms. */
typedef struct sinew_message {
  const void *data; /* message_bytes of it */
  const void *bulk; /* pixels; NULL: the topic has none */
  uint32_t message_bytes;
  uint32_t bulk_bytes; /* of the pixels that are used */
  uint32_t topic;
  uint32_t sequence;    /* counts the topic's messages; wraps */
  int64_t stamp_ns;     /* when the world was measured; 0: the message has no stamp */
  int64_t published_ns; /* when the robot published it */
  uint32_t missed;      /* sinew_wait(), sinew_next(): messages that this handle did not get since the one before */
  uint32_t reserved[5];
} sinew_message;

/* The newest message. Errors: not_found before the first; busy: the writer is faster than this reader. */
SINEW_API int sinew_latest(const sinew_robot *robot, uint32_t topic, sinew_message *message);
/* The newest message, as soon as there is one that this handle has not got from sinew_wait() or sinew_next() yet;
 * sleeps until then. timeout_ns < 0: 200 ms. Errors: timeout; closed: the robot ended. */
SINEW_API int sinew_wait(sinew_robot *robot, uint32_t topic, int64_t timeout_ns, sinew_message *message);
/* Like sinew_wait(), but one message after the other; those that are gone meanwhile are counted in `missed`. */
SINEW_API int sinew_next(sinew_robot *robot, uint32_t topic, int64_t timeout_ns, sinew_message *message);
/* How sinew_wait() and sinew_next() are woken by this topic. 0, as after sinew_attach(): a thread of the robot with
 * ordinary priority looks for messages each millisecond. Not 0: the thread that publishes wakes this program itself,
 * with one system call, so that the message is here as soon as the machine can do it. Errors: not_supported: the robot
 * file does not say wake_outsiders = true for this topic. */
SINEW_API int sinew_wake_at_once(sinew_robot *robot, uint32_t topic, int on);
/* 1: all that was read of the message until now is what the robot published. 0: it was overwritten. */
SINEW_API int sinew_still_valid(const sinew_robot *robot, const sinew_message *message);
/* Copies message_bytes and then bulk_bytes. Errors: bad_argument: `bytes` is less than both; overwritten. */
SINEW_API int sinew_copy(const sinew_robot *robot, const sinew_message *message, void *into, size_t bytes);

/* ---- Parameters and everything else */

enum { SINEW_BOOL, SINEW_INTEGER, SINEW_NUMBER, SINEW_TEXT };
typedef struct sinew_value {
  int32_t kind;    /* SINEW_NUMBER, ... */
  int32_t boolean; /* SINEW_BOOL: 0 or 1 */
  int64_t integer;
  double number;
  const char *text; /* SINEW_TEXT; of sinew_param_get(): until the next call with this handle */
} sinew_value;
SINEW_API int sinew_param_get(sinew_robot *robot, const char *module, const char *param, sinew_value *value);
/* Answers when the module's thread has taken it. An integer is taken for a number, too. Errors: bad_argument: what is
 * allowed is in sinew_last_error(). */
SINEW_API int sinew_param_set(sinew_robot *robot, const char *module, const char *param, const sinew_value *value);
/* Any request of docs/robot-socket.md: `arguments` is a JSON object or NULL, *reply a JSON object, until the next call
 * with this handle. A refusal of the robot is its code, and *reply is set all the same (NULL after other errors). */
SINEW_API int sinew_request(sinew_robot *robot, const char *name, const char *arguments, const char **reply);

/* ---- Messages to the robot: topics with writer = "external" */

/* A place for one message in memory that both sides share, to be filled without a further copy in this process: the
 * message's structure, all zero, and room for bulk_room bytes of pixels. Until the next sinew_loan() or sinew_publish()
 * with this handle. Errors: not_supported: the topic is written by a module. */
SINEW_API int sinew_loan(sinew_robot *robot, uint32_t topic, void **message, void **bulk, size_t *bulk_room);
enum {
  SINEW_NO_WAIT = 1 /* answers when the robot has accepted the message, not only when its thread has taken it */
};
/* Publishes what the last sinew_loan() gave, with the first bulk_bytes of the pixels. stamp_ns: when it was measured,
 * on the robot's clock and not in its future; 0: the instant at which the robot's thread takes it. The message's own
 * `stamp` does not count. An image says its width, height, stride and format in its fields; capacity_bytes does not
 * count. Errors: busy: earlier messages still wait for the thread; bad_argument with the reason. */
SINEW_API int sinew_send(sinew_robot *robot, size_t bulk_bytes, int64_t stamp_ns, unsigned flags);
/* Loan, copy and send in one call. message_bytes is that of the topic. */
SINEW_API int sinew_publish(sinew_robot *robot, uint32_t topic, const void *message, size_t message_bytes,
                            const void *bulk, size_t bulk_bytes, int64_t stamp_ns, unsigned flags);

#ifdef __cplusplus
}
#endif
#endif
