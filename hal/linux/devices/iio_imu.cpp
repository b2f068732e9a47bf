#include "hal/linux/devices/iio_imu.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <utility>

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr Duration kClockSlack = 1s;  // a stamp farther away is from another clock

std::vector<std::string> split(const std::string& names) {
  std::vector<std::string> out;
  for (std::size_t from = 0;;) {
    const std::size_t comma = names.find(',', from);
    out.push_back(names.substr(from, comma == std::string::npos ? comma : comma - from));
    if (comma == std::string::npos) return out;
    from = comma + 1;
  }
}

}  // namespace

Result<std::unique_ptr<IioImu>> IioImu::open(Os& os, const IioSpec& spec, std::string& why, IioOptions options) {
  if (spec.buffered == false && spec.rate_hz <= 0) {
    why = "iio device '" + spec.name + "': polled (buffered = false) needs rate_hz";
    return Error{Errc::bad_argument, "iio"};
  }
  std::unique_ptr<IioImu> imu(new IioImu(os, spec, std::move(options)));
  if (auto done = imu->connect(why); !done) return done.error();
  imu->stop_ = ::eventfd(0, EFD_CLOEXEC);
  if (imu->stop_ < 0) return Error{Errc::io, "eventfd", errno};
  auto thread = os.start_thread(imu->options_.thread, [i = imu.get()] { i->run(); });
  if (!thread) {
    why = "iio device '" + spec.name + "': its thread cannot be started: " + to_string(thread.error().code);
    return thread.error();
  }
  imu->thread_ = std::move(*thread);
  return imu;
}

IioImu::IioImu(Os& os, const IioSpec& spec, IioOptions options)
    : SensorQueue(std::max<std::size_t>(64, spec.buffer_length)),
      os_(os),
      spec_(spec),
      options_(std::move(options)),
      buffered_(spec.trigger.empty() ? spec.buffered : spec.buffered.value_or(true)) {}

IioImu::~IioImu() {
  if (thread_) {
    const std::uint64_t one = 1;
    while (::write(stop_, &one, sizeof one) < 0 && errno == EINTR) {
    }
    thread_.reset();
  }
  if (stop_ >= 0) ::close(stop_);
}

IioStats IioImu::stats() const {
  return {.samples = delivered(),
          .lost = lost(),
          .bad = bad_.value(),
          .unjoined = unjoined_.load(),
          .restarts = restarts_.value()};
}

std::string IioImu::shortfall() const {
  std::string text = thread_ ? thread_->shortfall() : std::string();
  if (!polled_because_.empty()) text += (text.empty() ? "" : "; ") + polled_because_;
  return text;
}

Status IioImu::connect(std::string& why) {
  if (buffered_) return connect_as(*buffered_, why);
  const Status done = connect_as(true, why);
  if (done) {
    buffered_ = true;
    return done;
  }
  // The device has no buffer, or it does not start. Other errors: denied, busy, not there, a wrong key.
  if (done.error().code != Errc::not_supported) return done;
  if (spec_.rate_hz <= 0) {
    why += "; with rate_hz it would be polled instead";
    return done;
  }
  const std::string because = std::exchange(why, {});
  if (const Status polled = connect_as(false, why); !polled) {
    why = because + "; nor can it be polled: " + why;
    return polled;
  }
  buffered_ = false;
  char rate[32];
  std::snprintf(rate, sizeof rate, "%.9g", spec_.rate_hz);
  polled_because_ = std::string("polled ") + rate + " times a second, with the stamps of reading: " + because;
  return {};
}

Status IioImu::connect_as(bool buffered, std::string& why) {
  devices_.clear();
  std::vector<std::unique_ptr<IioDevice>> found;
  const std::vector<std::string> names = split(spec_.name);
  if (names.size() > 2) {
    why = "iio device '" + spec_.name + "': one name, or accelerometer,gyroscope";
    return Error{Errc::bad_argument, "iio"};
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    auto device = IioDevice::find(spec_.root, names[i], why);
    if (!device) return device.error();
    std::vector<std::string> sensors{"accel", "anglvel"};
    if (names.size() == 2) sensors = {sensors[i]};
    for (const std::string& sensor : sensors)
      if (!(*device)->has(sensor)) {
        why = (*device)->title() + ": has no in_" + sensor + "_x_raw; it has: " + (*device)->channels();
        if (names.size() == 1) why += " (two devices are written \"accelerometer,gyroscope\")";
        return Error{Errc::bad_argument, "iio: no such sensor"};
      }
    if (auto done = (*device)->set_up(spec_, buffered, sensors, why); !done) return done;
    auto started = buffered ? (*device)->start_buffer(spec_, why) : (*device)->start_polling(why);
    if (!started) return started;
    found.push_back(std::move(*device));
  }
  std::size_t bytes = 0;
  for (const auto& d : found) bytes = std::max(bytes, d->scan_bytes());
  space_.resize(bytes * std::max(1u, spec_.buffer_length));
  devices_ = std::move(found);
  last_.assign(devices_.size(), Time{INT64_MIN});
  join_ = {};
  next_poll_ = heard_ = os_.now();
  silent_told_ = clock_told_ = repeats_told_ = false;
  return {};
}

void IioImu::run() noexcept {
  for (;;) {
    const Time deadline = *buffered_ ? os_.now() + options_.silent_after : next_poll_;
    if (!wait(deadline)) return;
    const Status done = *buffered_ ? read_all() : poll_all();
    if (done) {
      if (!silent_told_ && os_.now() - heard_ >= options_.silent_after) {
        silent_told_ = true;
        trouble_.set("iio device '" + spec_.name + "': is there, but sends nothing (trigger, interrupt?)");
      }
      continue;
    }
    trouble_.set("iio device '" + spec_.name + "': gone: " + done.error().where);
    devices_.clear();
    set_gone(true);
    retry();
    if (devices_.empty()) return;
    restarts_.add();
    trouble_.set({});
    set_gone(false);
  }
}

void IioImu::retry() noexcept {
  for (Duration pause = options_.retry_first;; pause = std::min(2 * pause, options_.retry_most)) {
    if (!wait(os_.now() + pause)) return;
    std::string why;
    if (connect(why)) return;
    devices_.clear();
    trouble_.set(why);
  }
}

bool IioImu::wait(Time deadline) noexcept {
  std::array<pollfd, 3> fds{pollfd{stop_, POLLIN, 0}};
  nfds_t count = 1;
  for (const auto& d : devices_)
    if (d->buffered()) fds[count++] = {d->fd(), POLLIN, 0};
  const std::int64_t left = std::max<std::int64_t>(0, (deadline - os_.now()).count());
  const timespec limit{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
  ::ppoll(fds.data(), count, &limit, nullptr);
  return (fds[0].revents & POLLIN) == 0;
}

Status IioImu::read_all() noexcept {
  for (std::size_t i = 0; i < devices_.size(); ++i)
    if (auto done = read_buffer(i); !done) return done;
  return {};
}

Status IioImu::read_buffer(std::size_t device) noexcept {
  IioDevice& d = *devices_[device];
  pollfd state{d.fd(), POLLIN, 0};
  ::poll(&state, 1, 0);  // for pipes that hang up; for an unplugged device the kernel's poll() reports nothing
  const auto size = d.read(space_);
  if (!size) return size.error();
  if (*size == 0 && (state.revents & (POLLHUP | POLLERR))) return Error{Errc::closed, "its buffer hung up"};
  const Time now = os_.now();
  const std::size_t bytes = d.scan_bytes();
  for (std::size_t at = 0; at < *size; at += bytes) {
    const std::span<const std::uint8_t> scan(space_.data() + at, bytes);
    const Time stamp = checked(device, d.stamp(scan).value_or(0), now);
    if (stamp <= last_[device]) {
      bad_.add();
      doubted_ = now;
      if (!repeats_told_)
        trouble_.set(d.title() + ": sends samples with the stamp of the one before, or an older one; they are dropped");
      repeats_told_ = true;
      continue;
    }
    last_[device] = stamp;
    std::array<std::array<double, 3>, 2> raw{};
    raw[0] = d.raw(scan, 0);
    if (devices_.size() == 1) raw[1] = d.raw(scan, 1);
    take(device, stamp, raw.data());
  }
  return {};
}

Time IioImu::checked(std::size_t device, std::int64_t stamp_ns, Time now) noexcept {
  const Time stamp{stamp_ns};
  const bool near = stamp - now < kClockSlack && now - stamp < kClockSlack;
  if (near) return stamp;
  doubted_ = now;
  if (!clock_told_ && stamp_ns != 0) {
    clock_told_ = true;
    trouble_.set(devices_[device]->title() +
                 ": its stamps are not of the monotonic clock; the time of reading is used");
  }
  return std::max(now, last_[device] + Duration{1});
}

Status IioImu::poll_all() noexcept {
  const Time now = os_.now();
  if (now < next_poll_) return {};
  const Duration period{static_cast<std::int64_t>(1e9 / spec_.rate_hz)};
  next_poll_ = std::max(next_poll_ + period, now);  // no burst after a long wait
  std::array<std::array<double, 3>, 2> raw{};
  for (std::size_t i = 0; i < 2; ++i) {
    const bool one = devices_.size() == 1;
    const auto value = devices_[one ? 0 : i]->poll(one ? i : 0);
    if (!value && value.error().code == Errc::bad_data) {
      bad_.add();
      return {};
    }
    if (!value) return value.error();
    raw[i] = *value;
  }
  msg::ImuSample out;
  out.stamp = now + (os_.now() - now) / 2;
  out.accel_mps2 = devices_[0]->axes(0).to_board(raw[0]);
  out.gyro_radps = devices_.size() == 1 ? devices_[0]->axes(1).to_board(raw[1]) : devices_[1]->axes(0).to_board(raw[1]);
  heard_ = now;
  put(out);
  return {};
}

void IioImu::take(std::size_t device, Time stamp, const std::array<double, 3>* raw) noexcept {
  heard_ = os_.now();
  const bool over = (clock_told_ || repeats_told_) && heard_ - doubted_ > options_.silent_after;
  if (silent_told_ || over) {
    silent_told_ = clock_told_ = repeats_told_ = false;
    trouble_.set({});
  }
  const IioDevice& d = *devices_[device];
  if (devices_.size() == 1) {
    msg::ImuSample out;
    out.stamp = stamp;
    out.accel_mps2 = d.axes(0).to_board(raw[0]);
    out.gyro_radps = d.axes(1).to_board(raw[1]);
    put(out);
    return;
  }
  const auto deliver = [this](const msg::ImuSample& s) { put(s); };
  if (device == 0)
    join_.add_accel(stamp, d.axes(0).to_board(raw[0]), deliver);
  else
    join_.add_gyro(stamp, d.axes(0).to_board(raw[0]), deliver);
  unjoined_.store(join_.dropped());
}

Result<std::unique_ptr<Imu>> open_iio_imu(Os& os, const IioSpec& spec, std::string& why) {
  IioOptions options;
  options.thread.fifo_priority = spec.fifo_priority;
  auto imu = IioImu::open(os, spec, why, std::move(options));
  if (!imu) return imu.error();
  return std::unique_ptr<Imu>(std::move(*imu));
}

}  // namespace sinew::hal
