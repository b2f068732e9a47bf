/* sinew_mex(COMMAND, ...): running Sinew robots from Octave and Matlab. docs/clients.md shows how it is built and used.
 *
 *   names = sinew_mex("robots")                        cell array
 *   r = sinew_mex("attach", NAME)                      "": the only robot that runs
 *   sinew_mex("detach", r)
 *   m = sinew_mex("wait" | "next" | "latest", r, TOPIC [, TIMEOUT_S])
 *         a struct of the message's fields, those with dots as structs in structs; and stamp_ns, published_ns,
 *         sequence, missed, and of images pixels: uint8, height x width (x channels). []: none in time.
 *   sinew_mex("publish", r, TOPIC, STRUCT [, PIXELS, STAMP_NS])
 *         fields as "wait" gives them, others are 0; choices by number. PIXELS: uint8, height x width (x channels),
 * whose width, height and stride follow from it. v = sinew_mex("get", r, MODULE, PARAM)             sinew_mex("set", r,
 * MODULE, PARAM, VALUE) json = sinew_mex("request", r, NAME [, JSON]) ns = sinew_mex("now", r) the robot's clock, int64
 *
 * All that it gives is a copy: arrays of Octave belong to Octave.
 */
#include <stdio.h>
#include <string.h>

#include "mex.h"
#include "sinew_client.h"

enum { kMaxRobots = 16, kMaxPath = 256 };

static sinew_robot* robots[kMaxRobots]; /* by handle - 1 */

static void detach_all(void) {
  for (int i = 0; i < kMaxRobots; ++i) {
    sinew_detach(robots[i]);
    robots[i] = NULL;
  }
}

static void check(int code) {
  if (code == SINEW_OK) return;
  char id[64];
  snprintf(id, sizeof id, "sinew:%s", sinew_code_name(code));
  mexErrMsgIdAndTxt(id, "%s", sinew_last_error());
}

static void refuse(const char* why) { mexErrMsgIdAndTxt("sinew:bad_argument", "%s", why); }

/* The argument as text; freed by mex at the end of the call. */
static char* text(int n, const mxArray* args[], int at, const char* what) {
  if (at >= n || !mxIsChar(args[at])) refuse(what);
  return mxArrayToString(args[at]);
}

static sinew_robot* robot_of(int n, const mxArray* args[]) {
  if (n < 2 || !mxIsNumeric(args[1]) || mxGetNumberOfElements(args[1]) != 1)
    refuse("a robot, from sinew_mex(\"attach\", ...)");
  const double handle = mxGetScalar(args[1]);
  if (!(handle >= 1 && handle <= kMaxRobots) || !robots[(int)handle - 1]) refuse("this robot is not attached");
  return robots[(int)handle - 1];
}

static mxArray* int64_scalar(int64_t value) {
  mxArray* array = mxCreateNumericMatrix(1, 1, mxINT64_CLASS, mxREAL);
  *(int64_t*)mxGetData(array) = value;
  return array;
}

static int64_t int64_of(const mxArray* array) {
  return mxIsInt64(array) ? *(const int64_t*)mxGetData(array) : (int64_t)mxGetScalar(array);
}

/* ---- structs: "gyro_radps.x" is s.gyro_radps.x, "found[2].u_px" is s.found_2.u_px (counted from 1 there: found_3) */

/* The next part of a field's name, with letters that a name in Octave may have. Answers what follows it, NULL: nothing.
 */
static const char* part_of(const char* name, char* part, size_t size) {
  size_t n = 0;
  unsigned index = 0;
  while (*name && *name != '.' && *name != '[' && n + 1 < size) part[n++] = *name++;
  part[n] = '\0';
  if (*name == '[') {
    if (sscanf(name, "[%u]", &index) == 1) snprintf(part + n, size - n, "_%u", index + 1);
    while (*name && *name != ']') ++name;
    if (*name) ++name;
  }
  return *name == '.' ? name + 1 : NULL;
}

static void put_field(mxArray* where, const char* name, mxArray* value) {
  char part[kMaxPath];
  const char* rest = part_of(name, part, sizeof part);
  mxArray* inner = mxGetField(where, 0, part);
  if (!inner) {
    if (mxGetFieldNumber(where, part) < 0) mxAddField(where, part);
    inner = rest ? mxCreateStructMatrix(1, 1, 0, NULL) : value;
    mxSetField(where, 0, part, inner);
  }
  if (rest) put_field(inner, rest, value);
}

/* NULL: the struct does not have it. */
static const mxArray* find_field(const mxArray* where, const char* name) {
  char part[kMaxPath];
  const char* rest = part_of(name, part, sizeof part);
  const mxArray* inner = mxIsStruct(where) ? mxGetField(where, 0, part) : NULL;
  return inner && rest ? find_field(inner, rest) : inner;
}

/* Every name in a struct that is not of the message: a typing error must not become a zero. */
static void check_names(sinew_robot* robot, uint32_t topic, const mxArray* values, const char* prefix) {
  sinew_topic about;
  check(sinew_topic_at(robot, topic, &about));
  for (int i = 0; i < mxGetNumberOfFields(values); ++i) {
    const char* name = mxGetFieldNameByNumber(values, i);
    char path[kMaxPath];
    int known = 0;
    snprintf(path, sizeof path, "%s%s", prefix, name);
    for (uint32_t f = 0; f < about.field_count && !known; ++f) {
      sinew_field field;
      char flat[kMaxPath] = "", part[kMaxPath / 2]; /* a robot's names have 64 letters at most */
      check(sinew_field_at(robot, topic, f, &field));
      for (const char* rest = field.name; rest;) {
        rest = part_of(rest, part, sizeof part);
        const size_t n = strlen(flat);
        snprintf(flat + n, sizeof flat - n, "%s%s", n ? "." : "", part);
      }
      const size_t n = strlen(path);
      known = strncmp(flat, path, n) == 0 && (flat[n] == '\0' || flat[n] == '.');
    }
    if (!known) mexErrMsgIdAndTxt("sinew:not_found", "%s has no field %s", about.type, path);
    const mxArray* inner = mxGetFieldByNumber(values, 0, i);
    if (inner && mxIsStruct(inner)) {
      strncat(path, ".", sizeof path - strlen(path) - 1);
      check_names(robot, topic, inner, path);
    }
  }
}

static const mxClassID kClasses[] = {mxINT8_CLASS,   mxUINT8_CLASS, mxINT16_CLASS,  mxUINT16_CLASS, mxINT32_CLASS,
                                     mxUINT32_CLASS, mxINT64_CLASS, mxUINT64_CLASS, mxSINGLE_CLASS, mxDOUBLE_CLASS};
static const size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};

/* Octave has columns, images have rows: pixel (row, column, channel). */
static mxArray* pixels_of(const unsigned char* rows, size_t height, size_t width, size_t stride, size_t channels) {
  const mwSize size[3] = {height, width, channels};
  mxArray* array = mxCreateNumericArray(3, size, mxUINT8_CLASS, mxREAL);
  unsigned char* to = mxGetData(array);
  for (size_t c = 0; c < channels; ++c)
    for (size_t x = 0; x < width; ++x)
      for (size_t y = 0; y < height; ++y) *to++ = rows[y * stride + x * channels + c];
  return array;
}

static uint32_t number_in(sinew_robot* robot, uint32_t topic, const unsigned char* message, const char* name) {
  sinew_field field;
  uint32_t value = 0;
  check(sinew_field_find(robot, topic, name, &field));
  memcpy(&value, message + field.offset, sizeof value);
  return value;
}

/* copy: the message's bytes, then its bulk's. */
static mxArray* message_struct(sinew_robot* robot, const sinew_message* m, const unsigned char* copy) {
  sinew_topic about;
  mxArray* result = mxCreateStructMatrix(1, 1, 0, NULL);
  check(sinew_topic_at(robot, m->topic, &about));
  for (uint32_t f = 0; f < about.field_count; ++f) {
    sinew_field field;
    check(sinew_field_at(robot, m->topic, f, &field));
    mxArray* value = mxCreateNumericMatrix(1, field.count, kClasses[field.kind], mxREAL);
    memcpy(mxGetData(value), copy + field.offset, field.count * kSizes[field.kind]);
    put_field(result, field.name, value);
  }
  put_field(result, "stamp_ns", int64_scalar(m->stamp_ns));
  put_field(result, "published_ns", int64_scalar(m->published_ns));
  put_field(result, "sequence", mxCreateDoubleScalar(m->sequence));
  put_field(result, "missed", mxCreateDoubleScalar(m->missed));
  if (m->bulk && strcmp(about.type, "Image") == 0) {
    static const size_t kChannels[] = {0, 1, 3, 3, 2}; /* none, mono8, rgb8, bgr8, yuyv */
    const uint32_t height = number_in(robot, m->topic, copy, "height"),
                   width = number_in(robot, m->topic, copy, "width");
    const uint32_t stride = number_in(robot, m->topic, copy, "stride"),
                   format = number_in(robot, m->topic, copy, "format");
    const size_t channels = format < sizeof kChannels / sizeof *kChannels ? kChannels[format] : 0;
    if ((uint64_t)stride * height > m->bulk_bytes || (uint64_t)width * channels > stride)
      refuse("an image that is not whole");
    put_field(result, "pixels", pixels_of(copy + m->message_bytes, height, width, stride, channels));
  }
  return result;
}

/* A message that is overwritten while it is read counts as missed, and the one after it is read. */
static mxArray* get_message(const char* command, int n, const mxArray* args[]) {
  sinew_robot* robot = robot_of(n, args);
  const double timeout_s = n > 3 ? mxGetScalar(args[3]) : 0.2;
  const int64_t timeout_ns = (int64_t)((timeout_s > 0 ? timeout_s : 0) * 1e9);
  uint32_t topic, overwritten = 0;
  sinew_message message;
  check(sinew_topic_find(robot, text(n, args, 2, "the name of a topic"), &topic));
  for (;;) {
    int code;
    if (strcmp(command, "latest") == 0)
      code = sinew_latest(robot, topic, &message);
    else
      code = (strcmp(command, "next") == 0 ? sinew_next : sinew_wait)(robot, topic, timeout_ns, &message);
    if (code == SINEW_TIMEOUT || (code == SINEW_NOT_FOUND && strcmp(command, "latest") == 0))
      return mxCreateDoubleMatrix(0, 0, mxREAL);
    check(code);
    const size_t bytes = (size_t)message.message_bytes + message.bulk_bytes;
    unsigned char* copy = mxMalloc(bytes);
    code = sinew_copy(robot, &message, copy, bytes);
    if (code == SINEW_OK) {
      message.missed += overwritten;
      mxArray* result = message_struct(robot, &message, copy);
      mxFree(copy);
      return result;
    }
    mxFree(copy);
    if (code != SINEW_OVERWRITTEN) check(code);
    ++overwritten;
  }
}

/* One element of a number of any class. */
static double element(const mxArray* array, size_t i) {
  switch (mxGetClassID(array)) {
    case mxDOUBLE_CLASS:
      return ((const double*)mxGetData(array))[i];
    case mxSINGLE_CLASS:
      return ((const float*)mxGetData(array))[i];
    case mxINT8_CLASS:
      return ((const int8_t*)mxGetData(array))[i];
    case mxUINT8_CLASS:
      return ((const uint8_t*)mxGetData(array))[i];
    case mxINT16_CLASS:
      return ((const int16_t*)mxGetData(array))[i];
    case mxUINT16_CLASS:
      return ((const uint16_t*)mxGetData(array))[i];
    case mxINT32_CLASS:
      return ((const int32_t*)mxGetData(array))[i];
    case mxUINT32_CLASS:
      return ((const uint32_t*)mxGetData(array))[i];
    case mxINT64_CLASS:
      return (double)((const int64_t*)mxGetData(array))[i];
    case mxUINT64_CLASS:
      return (double)((const uint64_t*)mxGetData(array))[i];
    case mxLOGICAL_CLASS:
      return ((const mxLogical*)mxGetData(array))[i] ? 1 : 0;
    default:
      refuse("a number");
      return 0;
  }
}

static void put_number(unsigned char* to, uint32_t kind, double value) {
#define PUT(TYPE)               \
  do {                          \
    const TYPE v = (TYPE)value; \
    memcpy(to, &v, sizeof v);   \
  } while (0)
  if (kind < SINEW_F32 && !(value > -9.3e18 && value < 1.9e19)) refuse("a number that an integer can hold");
  switch (kind) {
    case SINEW_I8:
      PUT(int8_t);
      break;
    case SINEW_U8:
      PUT(uint8_t);
      break;
    case SINEW_I16:
      PUT(int16_t);
      break;
    case SINEW_U16:
      PUT(uint16_t);
      break;
    case SINEW_I32:
      PUT(int32_t);
      break;
    case SINEW_U32:
      PUT(uint32_t);
      break;
    case SINEW_I64:
      PUT(int64_t);
      break;
    case SINEW_U64:
      PUT(uint64_t);
      break;
    case SINEW_F32:
      PUT(float);
      break;
    default:
      PUT(double);
      break;
  }
#undef PUT
}

static void put_values(sinew_robot* robot, uint32_t topic, const mxArray* values, unsigned char* message) {
  sinew_topic about;
  check(sinew_topic_at(robot, topic, &about));
  check_names(robot, topic, values, "");
  for (uint32_t f = 0; f < about.field_count; ++f) {
    sinew_field field;
    check(sinew_field_at(robot, topic, f, &field));
    const mxArray* value = find_field(values, field.name);
    if (!value) continue;
    if (mxGetNumberOfElements(value) != field.count)
      mexErrMsgIdAndTxt("sinew:bad_argument", "%s: %u numbers are wanted", field.name, (unsigned)field.count);
    for (uint32_t i = 0; i < field.count; ++i)
      put_number(message + field.offset + i * kSizes[field.kind], field.kind, element(value, i));
  }
}

static void put_header(sinew_robot* robot, uint32_t topic, unsigned char* message, const char* name, double value) {
  sinew_field field;
  check(sinew_field_find(robot, topic, name, &field));
  put_number(message + field.offset, field.kind, value);
}

static void publish(int n, const mxArray* args[]) {
  sinew_robot* robot = robot_of(n, args);
  uint32_t topic;
  void *message, *bulk;
  size_t room, used = 0;
  check(sinew_topic_find(robot, text(n, args, 2, "the name of a topic"), &topic));
  if (n < 4 || !mxIsStruct(args[3]) || mxGetNumberOfElements(args[3]) != 1)
    refuse("a struct with the message's fields");
  check(sinew_loan(robot, topic, &message, &bulk, &room));
  if (n > 4 && !mxIsEmpty(args[4])) {
    const mwSize* size = mxGetDimensions(args[4]);
    const size_t height = size[0], width = size[1], channels = mxGetNumberOfDimensions(args[4]) > 2 ? size[2] : 1;
    static const double kFormats[] = {0, 1, 4, 2}; /* mono8, yuyv, rgb8 by their channels */
    if (!mxIsUint8(args[4]) || channels > 3) refuse("pixels: uint8, height x width (x channels)");
    used = height * width * channels;
    if (used > room) refuse("more pixels than the topic has room for");
    const unsigned char* from = mxGetData(args[4]);
    for (size_t c = 0; c < channels; ++c)
      for (size_t x = 0; x < width; ++x)
        for (size_t y = 0; y < height; ++y) ((unsigned char*)bulk)[(y * width + x) * channels + c] = *from++;
    put_header(robot, topic, message, "width", (double)width);
    put_header(robot, topic, message, "height", (double)height);
    put_header(robot, topic, message, "stride", (double)(width * channels));
    put_header(robot, topic, message, "format", kFormats[channels]);
  }
  put_values(robot, topic, args[3], message);
  check(sinew_send(robot, used, n > 5 ? int64_of(args[5]) : 0, 0));
}

static mxArray* list(void) {
  sinew_robots* all;
  check(sinew_robots_list(&all));
  mxArray* names = mxCreateCellMatrix(1, sinew_robots_count(all));
  for (size_t i = 0; i < sinew_robots_count(all); ++i) mxSetCell(names, i, mxCreateString(sinew_robots_name(all, i)));
  sinew_robots_free(all);
  return names;
}

static mxArray* attach(int n, const mxArray* args[]) {
  int free_place = 0;
  while (free_place < kMaxRobots && robots[free_place]) ++free_place;
  if (free_place == kMaxRobots) refuse("16 robots are attached already");
  check(sinew_attach(n > 1 ? text(n, args, 1, "the name of a robot") : "", &robots[free_place]));
  return mxCreateDoubleScalar(free_place + 1);
}

static mxArray* get_param(int n, const mxArray* args[]) {
  sinew_value value;
  check(sinew_param_get(robot_of(n, args), text(n, args, 2, "a module"), text(n, args, 3, "a parameter"), &value));
  switch (value.kind) {
    case SINEW_BOOL:
      return mxCreateLogicalScalar(value.boolean != 0);
    case SINEW_INTEGER:
      return int64_scalar(value.integer);
    case SINEW_NUMBER:
      return mxCreateDoubleScalar(value.number);
    default:
      return mxCreateString(value.text);
  }
}

static void set_param(int n, const mxArray* args[]) {
  sinew_value value;
  memset(&value, 0, sizeof value);
  if (n < 5) refuse("module, parameter and value");
  if (mxIsChar(args[4])) {
    value.kind = SINEW_TEXT, value.text = mxArrayToString(args[4]);
  } else if (mxIsLogical(args[4])) {
    value.kind = SINEW_BOOL, value.boolean = mxIsLogicalScalarTrue(args[4]);
  } else if (mxGetScalar(args[4]) == (double)(int64_t)mxGetScalar(args[4])) { /* for an integer or a number */
    value.kind = SINEW_INTEGER, value.integer = (int64_t)mxGetScalar(args[4]);
  } else {
    value.kind = SINEW_NUMBER, value.number = mxGetScalar(args[4]);
  }
  check(sinew_param_set(robot_of(n, args), text(n, args, 2, "a module"), text(n, args, 3, "a parameter"), &value));
}

void mexFunction(int results, mxArray* result[], int n, const mxArray* args[]) {
  (void)results;
  mexAtExit(detach_all);
  const char* command =
      text(n, args, 0, "a command: robots, attach, detach, wait, next, latest, publish, get, set, request, now");
  if (strcmp(command, "robots") == 0) {
    result[0] = list();
  } else if (strcmp(command, "attach") == 0) {
    result[0] = attach(n, args);
  } else if (strcmp(command, "detach") == 0) {
    sinew_robot* robot = robot_of(n, args);
    robots[(int)mxGetScalar(args[1]) - 1] = NULL;
    sinew_detach(robot);
  } else if (strcmp(command, "wait") == 0 || strcmp(command, "next") == 0 || strcmp(command, "latest") == 0) {
    result[0] = get_message(command, n, args);
  } else if (strcmp(command, "publish") == 0) {
    publish(n, args);
  } else if (strcmp(command, "get") == 0) {
    result[0] = get_param(n, args);
  } else if (strcmp(command, "set") == 0) {
    set_param(n, args);
  } else if (strcmp(command, "request") == 0) {
    const char* reply;
    check(sinew_request(robot_of(n, args), text(n, args, 2, "a request"), n > 3 ? text(n, args, 3, "JSON") : NULL,
                        &reply));
    result[0] = mxCreateString(reply);
  } else if (strcmp(command, "now") == 0) {
    int64_t now_ns;
    check(sinew_now(robot_of(n, args), &now_ns, NULL));
    result[0] = int64_scalar(now_ns);
  } else {
    mexErrMsgIdAndTxt("sinew:bad_argument", "no command \"%s\"", command);
  }
}
