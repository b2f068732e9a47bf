// The camera of an image server (USARSim's) beside the least that its pictures need: a request, recv(), libjpeg-turbo,
// in one thread and straight into the picture. Processor time of this process for each picture; another process serves.
//   image_server_bench [PAIRS]
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <turbojpeg.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <string>

#include "camera_scene.hpp"
#include "hal/linux/image_server/image_server_camera.hpp"
#include "hal/platform.hpp"
#include "images/encode.hpp"
#include "pairs.hpp"

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kWidth = 640, kHeight = 480, kPictures = 8;
constexpr int kOfOneMeasurement = 10, kMeasurements = 5;

[[noreturn]] void die(const char* what) {
  std::printf("image_server_bench: %s\n", what);
  std::exit(1);
}

void append32(Bytes& to, std::size_t number) {
  for (const int shift : {24, 16, 8, 0}) to.push_back(static_cast<std::uint8_t>(number >> shift));
}

/// One answer of the server: a picture, as JPEG of quality 80 or raw.
Bytes answer(const Bytes& yuyv, bool jpeg) {
  Bytes data;
  if (jpeg) {
    images::Encoder encoder;
    const auto file = encoder.encode({yuyv, kWidth, kHeight, 2 * kWidth, msg::PixelFormat::yuyv}, images::Kind::jpeg);
    if (!file) die(file.error().where);
    const auto* const from = reinterpret_cast<const std::uint8_t*>(file->data());
    data.assign(from, from + file->size());
  } else {
    for (const std::uint32_t side : {kWidth, kHeight})
      data.push_back(static_cast<std::uint8_t>(side >> 8)), data.push_back(static_cast<std::uint8_t>(side));
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) data.insert(data.end(), 3, yuyv[2 * i]);
  }
  Bytes all{static_cast<std::uint8_t>(jpeg ? 1 : 0)};
  append32(all, data.size());
  all.insert(all.end(), data.begin(), data.end());
  return all;
}

/// A process that answers two bytes with a picture, on as many connections as there are.
class Server {
 public:
  explicit Server(bool jpeg) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET, at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&at), sizeof at) != 0 || ::listen(listener_, 4) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&at), &size) != 0)
      die("no listener");
    port_ = ntohs(at.sin_port);
    process_ = ::fork();
    if (process_ == 0) serve(jpeg);
    ::close(listener_);
  }
  ~Server() {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  std::uint16_t port() const { return port_; }

 private:
  [[noreturn]] void serve(bool jpeg) const {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    std::vector<Bytes> answers;
    const ShadedDiscs discs(kWidth, kHeight);
    for (std::uint32_t p = 0; p < kPictures; ++p) answers.push_back(answer(discs.picture(p), jpeg));
    for (;;) {
      const int peer = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (peer < 0 || ::fork() != 0) {
        ::close(peer);
        continue;
      }
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      std::array<char, 2> request;
      for (std::size_t n = 0; ::recv(peer, request.data(), request.size(), MSG_WAITALL) == 2; ++n) {
        const Bytes& a = answers[n % kPictures];
        if (::send(peer, a.data(), a.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(a.size())) break;
      }
      std::_Exit(0);
    }
  }
  int listener_ = -1;
  std::uint16_t port_ = 0;
  pid_t process_ = -1;
};

/// A connection, a buffer and libjpeg-turbo.
class Floor {
 public:
  explicit Floor(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET, at.sin_port = htons(port), at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&at), sizeof at) != 0) die("no connection");
  }
  ~Floor() {
    tjDestroy(library_);
    ::close(socket_);
  }
  Floor(const Floor&) = delete;
  Floor& operator=(const Floor&) = delete;
  void picture() {
    if (::send(socket_, "OK", 2, MSG_NOSIGNAL) != 2) die("the server is gone");
    std::array<std::uint8_t, 5> head;
    take(head.data(), head.size());
    const std::size_t size =
        std::size_t{head[1]} << 24 | std::size_t{head[2]} << 16 | std::size_t{head[3]} << 8 | head[4];
    if (head[0] == 0) {
      std::array<std::uint8_t, 4> shape;
      take(shape.data(), shape.size());
      take(picture_->pixels(), size - shape.size());
    } else {
      bytes_.resize(size);
      take(bytes_.data(), size);
      if (tjDecompress2(library_, bytes_.data(), size, picture_->pixels(), kWidth, static_cast<int>(picture_->stride),
                        kHeight, TJPF_RGB, 0) != 0)
        die("no JPEG");
    }
    keep(picture_->pixels());
  }

 private:
  void take(std::uint8_t* to, std::size_t size) {
    if (::recv(socket_, to, size, MSG_WAITALL) != static_cast<ssize_t>(size)) die("the server is gone");
  }
  int socket_;
  tjhandle library_ = tjInitDecompress();
  Bytes bytes_;
  msg::ImageBuffer picture_{msg::PixelFormat::rgb8, kWidth, kHeight};
};

/// The camera, and a thread that takes its pictures as soon as it is woken.
class Ours final : public hal::Wake {
 public:
  explicit Ours(std::uint16_t port) {
    hal::ImageServerSpec spec;
    spec.endpoint = "tcp:127.0.0.1:" + std::to_string(port);
    spec.width = kWidth, spec.height = kHeight, spec.rate_hz = 0;
    std::string why;
    auto opened = hal::ImageServerCamera::open(spec, os_, why);
    if (!opened) die(why.c_str());
    camera_ = std::move(*opened);
    camera_->set_wake(this);
    until_ready();
  }
  ~Ours() override { camera_->set_wake(nullptr); }
  void wake() noexcept override {
    word_.fetch_add(1, std::memory_order_release);
    os_.wake(word_);
  }
  /// Takes one that is there, and waits for the next: afterwards its thread has nothing to do.
  void picture() {
    if (const auto got = camera_->read(*picture_); !got || !*got) die("no picture");
    keep(picture_->pixels());
    until_ready();
  }

 private:
  void until_ready() {
    for (;;) {
      const std::uint32_t seen = word_.load(std::memory_order_acquire);
      if (camera_->ready_at() != hal::kNever) return;
      os_.wait(word_, seen, os_.now() + 5s);
    }
  }
  hal::Os& os_ = hal::system_os();
  hal::WakeWord word_{0};
  std::unique_ptr<hal::Camera> camera_;
  msg::ImageBuffer picture_{msg::PixelFormat::rgb8, kWidth, kHeight};
};

double processor_us() {
  timespec t{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

bool measure(const char* name, bool jpeg, int pairs, double goal) {
  const Server server(jpeg);
  Ours ours(server.port());
  Floor floor(server.port());
  const auto batch = [](auto& of) {
    std::vector<double> us;
    for (int m = 0; m < kMeasurements; ++m) {
      const double start = processor_us();
      for (int i = 0; i < kOfOneMeasurement; ++i) of.picture();
      us.push_back((processor_us() - start) / kOfOneMeasurement);
    }
    return us;
  };
  batch(ours), batch(floor);  // warm-up
  Pairs all;
  for (int i = 0; i < pairs; ++i) {
    auto x = i % 2 == 0 ? batch(ours) : std::vector<double>();
    auto y = batch(floor);
    if (i % 2 != 0) x = batch(ours);
    all.add(std::move(x), std::move(y));
  }
  return report(name, all.ratio(), goal, "us of a processor");
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) {
  using namespace sinew;
  if (!hal::JpegDecoder::built()) {
    std::printf("image_server_bench: skipped, this build has no libjpeg-turbo\n");
    return 0;
  }
  const int pairs = std::max(5, argc > 1 ? std::atoi(argv[1]) : 15);
  const bool jpeg = bench::measure("image_server_jpeg_640x480", true, pairs, 1.2);
  const bool raw = bench::measure("image_server_raw_640x480", false, pairs, 0);
  return jpeg && raw ? 0 : 1;
}
