#include "record/run/run_messages.hpp"

#include "math/hash.hpp"
#include "record/run/cdr_stream.hpp"

namespace sinew::record {
namespace {

constexpr std::size_t kSmallestStep = 70;

void encode(CdrWriter& to, const LoggedStep& s) {
  to.number(s.order);
  to.number(s.release.ns);
  to.number(s.now.ns);
  to.number(s.completed.ns);
  to.number(std::int64_t{s.dt.count()});
  to.number(std::int64_t{s.exec.count()});
  to.number(s.module);
  to.number(s.number);
  to.number(s.device_state);
  to.number(static_cast<std::uint8_t>(s.status));
  to.boolean(s.timed_out);
  to.length(s.inputs.size());
  for (const LoggedStep::Input& in : s.inputs) {
    to.number(in.port);
    to.number(in.dropped);
    to.boolean(in.updated);
    to.length(in.sequences.size());
    for (const std::uint32_t sequence : in.sequences) to.number(sequence);
  }
  to.length(s.outputs.size());
  for (const LoggedStep::Output& out : s.outputs) {
    to.number(out.port);
    to.number(out.first);
    to.number(out.count);
    to.length(out.origin_ns.size());
    for (const std::int64_t origin : out.origin_ns) to.number(origin);
  }
}

void decode(CdrReader& from, LoggedStep& s) {
  s.order = from.number<std::uint64_t>();
  s.release.ns = from.number<std::int64_t>();
  s.now.ns = from.number<std::int64_t>();
  s.completed.ns = from.number<std::int64_t>();
  s.dt = rt::Duration{from.number<std::int64_t>()};
  s.exec = rt::Duration{from.number<std::int64_t>()};
  s.module = from.number<std::uint32_t>();
  s.number = from.number<std::uint32_t>();
  s.device_state = from.number<std::uint32_t>();
  s.status = static_cast<rt::StepStatus>(from.number<std::uint8_t>());
  s.timed_out = from.boolean();
  s.inputs.resize(from.length(13));
  for (LoggedStep::Input& in : s.inputs) {
    in.port = from.number<std::uint32_t>();
    in.dropped = from.number<std::uint32_t>();
    in.updated = from.boolean();
    in.sequences.resize(from.length(4));
    for (std::uint32_t& sequence : in.sequences) sequence = from.number<std::uint32_t>();
  }
  s.outputs.resize(from.length(16));
  for (LoggedStep::Output& out : s.outputs) {
    out.port = from.number<std::uint32_t>();
    out.first = from.number<std::uint32_t>();
    out.count = from.number<std::uint32_t>();
    out.origin_ns.resize(from.length(8));
    for (std::int64_t& origin : out.origin_ns) origin = from.number<std::int64_t>();
  }
}

}  // namespace

const RecordSchema& step_batch_schema() {
  static constexpr RecordSchema kSchema{"sinew_msgs/msg/StepBatch",
                                        R"(# Steps of one thread, in their order.
uint32 thread
Step[] steps
================================================================================
MSG: sinew_msgs/Step
uint64 order         # in the log of the thread, from 0, requests counted; a number that is missing was lost
int64 release_ns     # of its cycle
int64 now_ns         # start of the step: when it latched its inputs
int64 completed_ns   # when its outputs became visible
int64 dt_ns          # release to release
int64 exec_ns        # as the executor has it
uint32 module        # index in the metadata "sinew.modules"
uint32 number        # steps of the module since the start or the last reset
uint32 device_state  # what the driver's hooks had learned
uint8 status         # 0 ok, 1 stale, 2 fault
bool timed_out       # the cycle was released by its time-out
StepInput[] inputs   # every bound input
StepOutput[] outputs # every port that published
================================================================================
MSG: sinew_msgs/StepInput
uint32 port          # index in the module's declaration
uint32 dropped       # messages lost to a full queue since the step before
bool updated         # latest inputs: another message than in the step before
uint32[] sequences   # of the messages held, oldest first
================================================================================
MSG: sinew_msgs/StepOutput
uint32 port
uint32 first         # sequence
uint32 count
int64[] origin_ns    # by chain: oldest source stamp that went in; the largest int64: none
)"};
  return kSchema;
}

const RecordSchema& request_schema() {
  static constexpr RecordSchema kSchema{
      "sinew_msgs/msg/Request",
      R"(# What came in by the mailbox, when a thread took it: it acts on the steps behind it.
uint32 thread
uint64 order         # in the log of the thread
int64 now_ns
uint8 kind           # 0 set_param, 1 enable, 2 disable, 3 set_period, 4 arm, 5 disarm, 6 message
uint32 module
uint32 index         # set_param: of the module's parameters
uint8 value_kind     # 0 bool, 1 int64, 2 double
bool as_bool
int64 as_int         # set_period: nanoseconds
float64 as_double
uint32 step          # of the module, the first with it; set_period: of the thread's cycles
bool refused
)"};
  return kSchema;
}

const RecordSchema& state_schema() {
  static constexpr RecordSchema kSchema{"sinew_msgs/msg/ModuleState",
                                        R"(# What a module goes on from behind one of its steps.
uint32 thread
uint64 order         # in the log of the thread
uint32 module
uint32 number        # of the step before
int64 completed_ns   # of that step
uint64 layout        # only a module with the same one understands the bytes
uint8[] data
)"};
  return kSchema;
}

const RecordSchema& image_head_schema() {
  static constexpr RecordSchema kSchema{
      "sinew_msgs/msg/ImageHead",
      R"(# An image without its pixels; they are in the image topic under the same sequence, if they were kept.
int64 stamp            # ns, mid-point of the exposure
int64 exposure_ns
uint32 frame_number
uint32 width
uint32 height
uint32 stride          # B
uint32 format          # 1 mono8, 2 rgb8, 3 bgr8, 4 yuyv
uint32 capacity_bytes
uint64 pixel_hash      # XXH64 of the used bytes
bool has_pixels
)"};
  return kSchema;
}

void StepBatch::add(const LoggedStep& step) {
  constexpr std::size_t kCountAt = sizeof kEncapsulation + sizeof step.thread;
  if (count_++ == 0) {
    CdrWriter head(bytes_);
    head.number(step.thread);
    head.length(0);
    first_ = step.now;
  }
  CdrWriter cdr = CdrWriter::behind(bytes_);
  encode(cdr, step);
  Buffer::put(bytes_.data() + kCountAt, count_);
}

bool decode(std::span<const std::byte> bytes, std::vector<LoggedStep>& steps) {
  CdrReader cdr(bytes);
  const auto thread = cdr.number<std::uint32_t>();
  steps.resize(cdr.length(kSmallestStep));
  for (LoggedStep& s : steps) {
    decode(cdr, s);
    s.thread = thread;
  }
  if (cdr.at_end()) return true;
  steps.clear();
  return false;
}

void encode(Buffer& to, const LoggedRequest& r) {
  CdrWriter cdr(to);
  cdr.number(r.request.thread);
  cdr.number(r.order);
  cdr.number(r.now.ns);
  cdr.number(static_cast<std::uint8_t>(r.request.kind));
  cdr.number(r.request.module);
  cdr.number(r.request.index);
  cdr.number(static_cast<std::uint8_t>(r.request.value.index()));
  const auto* b = std::get_if<bool>(&r.request.value);
  const auto* i = std::get_if<std::int64_t>(&r.request.value);
  const auto* d = std::get_if<double>(&r.request.value);
  cdr.boolean(b && *b);
  cdr.number(i ? *i : std::int64_t{0});
  cdr.number(d ? *d : 0.0);
  cdr.number(r.effect.step);
  cdr.boolean(r.effect.refused);
}

bool decode(std::span<const std::byte> bytes, LoggedRequest& r) {
  using RequestKind = rt::Request::Kind;
  CdrReader cdr(bytes);
  r.request.thread = cdr.number<std::uint32_t>();
  r.order = cdr.number<std::uint64_t>();
  r.now.ns = cdr.number<std::int64_t>();
  const auto kind = cdr.number<std::uint8_t>();
  r.request.kind = static_cast<RequestKind>(kind);
  r.request.module = cdr.number<std::uint32_t>();
  r.request.index = cdr.number<std::uint32_t>();
  const auto value = cdr.number<std::uint8_t>();
  const bool as_bool = cdr.boolean();
  const auto as_int = cdr.number<std::int64_t>();
  const auto as_double = cdr.number<double>();
  if (value == 0) r.request.value = as_bool;
  if (value == 1) r.request.value = as_int;
  if (value == 2) r.request.value = as_double;
  r.effect.step = cdr.number<std::uint32_t>();
  r.effect.refused = cdr.boolean();
  return cdr.at_end() && kind <= static_cast<std::uint8_t>(RequestKind::message) && value <= 2;
}

void encode(Buffer& to, const LoggedState& state, std::uint64_t layout) {
  CdrWriter cdr(to);
  cdr.number(state.thread);
  cdr.number(state.order);
  cdr.number(state.module);
  cdr.number(state.number);
  cdr.number(state.completed.ns);
  cdr.number(layout);
  cdr.length(state.bytes.size());
  to.append(state.bytes);
}

bool decode(std::span<const std::byte> bytes, LoggedState& state, std::uint64_t& layout) {
  CdrReader cdr(bytes);
  state.thread = cdr.number<std::uint32_t>();
  state.order = cdr.number<std::uint64_t>();
  state.module = cdr.number<std::uint32_t>();
  state.number = cdr.number<std::uint32_t>();
  state.completed.ns = cdr.number<std::int64_t>();
  layout = cdr.number<std::uint64_t>();
  const std::uint32_t size = cdr.length(1);
  state.bytes = cdr.rest();
  return cdr.good() && state.bytes.size() == size;
}

ImageHead head_of(const msg::Image& image, bool has_pixels) {
  return {image.stamp,
          image.exposure_ns,
          image.frame_number,
          image.width,
          image.height,
          image.stride,
          static_cast<std::uint32_t>(image.format),
          image.capacity_bytes,
          math::hash64(image.pixels(), image.bulk_used()),
          has_pixels};
}

void encode(Buffer& to, const ImageHead& h) {
  CdrWriter cdr(to);
  cdr.number(h.stamp.ns);
  cdr.number(h.exposure_ns);
  for (const std::uint32_t v : {h.frame_number, h.width, h.height, h.stride, h.format, h.capacity_bytes}) cdr.number(v);
  cdr.number(h.pixel_hash);
  cdr.boolean(h.has_pixels);
}

bool decode(std::span<const std::byte> bytes, ImageHead& h) {
  CdrReader cdr(bytes);
  h.stamp.ns = cdr.number<std::int64_t>();
  h.exposure_ns = cdr.number<std::int64_t>();
  for (std::uint32_t* v : {&h.frame_number, &h.width, &h.height, &h.stride, &h.format, &h.capacity_bytes})
    *v = cdr.number<std::uint32_t>();
  h.pixel_hash = cdr.number<std::uint64_t>();
  h.has_pixels = cdr.boolean();
  return cdr.at_end();
}

void put_header(CdrWriter& to, std::int64_t stamp_ns, std::string_view frame_id) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t sec = stamp_ns / kSecond - (stamp_ns % kSecond < 0 ? 1 : 0);
  to.number(static_cast<std::int32_t>(sec));
  to.number(static_cast<std::uint32_t>(stamp_ns - sec * kSecond));
  to.text(frame_id);
}

void encode_image_head(Buffer& to, const msg::Image& image, std::int64_t unix_ns, std::string_view frame_id) {
  to.clear();
  to.append(msg::Ros2ImageHead::of_image(image, image.bulk_used(), unix_ns, frame_id).bytes());
}

std::optional<ImageView> view_image(std::span<const std::byte> bytes) {
  CdrReader cdr(bytes);
  ImageView view;
  const std::int64_t sec = cdr.number<std::int32_t>();
  view.stamp_ns = sec * 1'000'000'000 + cdr.number<std::uint32_t>();
  view.frame_id = cdr.text();
  view.height = cdr.number<std::uint32_t>();
  view.width = cdr.number<std::uint32_t>();
  view.encoding = cdr.text();
  cdr.boolean();
  view.stride = cdr.number<std::uint32_t>();
  const std::uint32_t size = cdr.length(1);
  if (!cdr.good() || cdr.rest().size() != size) return std::nullopt;
  view.pixels = cdr.rest();
  return view;
}

}  // namespace sinew::record
