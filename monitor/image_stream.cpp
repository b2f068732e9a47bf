#include "monitor/image_stream.hpp"

#include <fmt/format.h>

#include <cstring>
#include <list>
#include <utility>
#include <vector>

#include "hal/platform.hpp"
#include "msg/image.hpp"

namespace sinew::monitor {
namespace {

constexpr auto kLook = std::chrono::milliseconds(200);  // at most so long without a look at who is there
constexpr int kTries = 3;                               // to encode a picture in place before it is copied

struct RecipeState {
  explicit RecipeState(Recipe r) : recipe(std::move(r)) {}
  const Recipe recipe;
  images::Encoder encoder{};   // the stream's thread
  mutable std::mutex mutex{};  // of the rest
  Picture newest{};
};

struct Place {
  std::shared_ptr<RecipeState> state;
  ImageStream::OnNew on_new;
  std::uint64_t told = 0;  // serial; the stream's thread
};

std::span<const std::byte> as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

Bytes as_body(std::span<const std::byte> encoded, bool as_part, images::Kind kind) {
  auto body = std::make_shared<std::vector<std::byte>>();
  const auto add = [&](std::span<const std::byte> bytes) { body->insert(body->end(), bytes.begin(), bytes.end()); };
  if (!as_part) {
    body->assign(encoded.begin(), encoded.end());
    return body;
  }
  const std::string head = fmt::format("--{}\r\ncontent-type: {}\r\ncontent-length: {}\r\n\r\n", kPartBoundary,
                                       images::media_type(kind), encoded.size());
  body->reserve(head.size() + encoded.size() + 2);
  add(as_bytes(head)), add(encoded), add(as_bytes("\r\n"));
  return body;
}

class TopicStream final : public ImageStream, public std::enable_shared_from_this<TopicStream> {
 public:
  TopicStream(std::unique_ptr<tap::Client> client, const tap::SegmentReader* reader, std::uint32_t topic)
      : client_(std::move(client)),
        reader_(reader),
        topic_(topic),
        name_(reader->topics()[topic].name),
        bulk_bytes_(reader->topics()[topic].bulk_bytes) {
    thread_ = std::thread([this] { serve(); });
  }

  ~TopicStream() override {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

  std::shared_ptr<Viewer> look(const Recipe& recipe, OnNew on_new) override {
    auto viewer = std::make_shared<Look>();
    viewer->stream = shared_from_this();
    {
      const std::lock_guard lock(mutex_);
      viewer->place = std::make_shared<Place>();
      for (const auto& other : places_)
        if (other->state->recipe == recipe) viewer->place->state = other->state;
      if (!viewer->place->state) viewer->place->state = std::make_shared<RecipeState>(recipe);
      viewer->place->on_new = std::move(on_new);
      places_.push_back(viewer->place);
      ++looked_;
    }
    changed_.notify_one();
    return viewer;
  }

  bool is_gone() const override { return gone_.load(std::memory_order_relaxed); }

  Counters counters() const override { return {seen_.load(), encoded_.load(), torn_.load()}; }

 private:
  struct Look final : Viewer {
    ~Look() override {
      const std::lock_guard lock(stream->mutex_);
      stream->places_.remove(place);
    }
    Picture newest() const override {
      const std::lock_guard lock(place->state->mutex);
      return place->state->newest;
    }
    std::shared_ptr<TopicStream> stream;
    std::shared_ptr<Place> place;
  };

  void serve() {
    std::unique_lock lock(mutex_);
    while (true) {
      if (places_.empty()) {
        lock.unlock();
        subscribe(false);
        lock.lock();
        changed_.wait(lock, [this] { return stop_ || !places_.empty(); });
      }
      if (stop_) return;
      const std::vector<std::shared_ptr<Place>> places(places_.begin(), places_.end());
      const std::uint64_t looked = looked_;
      lock.unlock();
      subscribe(true);
      const std::uint32_t bell = client_->bell(topic_);
      serve(places);
      if (is_gone()) {
        for (const auto& place : places) place->on_new();
        lock.lock();
        changed_.wait(lock, [this] { return stop_; });
        return;
      }
      lock.lock();
      if (looked != looked_ || stop_) continue;  // a new viewer gets the picture of now
      lock.unlock();
      client_->wait(topic_, bell, hal::system_os().now() + kLook);
      lock.lock();
    }
  }

  void serve(const std::vector<std::shared_ptr<Place>>& places) {
    const auto message = reader_->newest(topic_);
    if (!message || (any_ && message->sequence == last_)) {
      // A robot that ended rings no bell: its socket tells.
      const hal::Time now = hal::system_os().now();
      if (now - asked_ >= kLook) {
        asked_ = now;
        if (!client_->request("hello")) gone_.store(true, std::memory_order_relaxed);
      }
    }
    if (!message) return;
    if (!any_ || message->sequence != last_) seen_.fetch_add(1, std::memory_order_relaxed);
    any_ = true, last_ = message->sequence;
    for (const auto& place : places) {
      RecipeState& state = *place->state;
      // Only this thread writes it.
      if (state.newest.serial == 0 || state.newest.sequence != last_) encode(state);
      if (place->told == state.newest.serial) continue;
      place->told = state.newest.serial;
      place->on_new();
    }
  }

  /// Reads the newest picture in place; one that was overwritten meanwhile is none.
  void encode(RecipeState& state) {
    Picture picture;
    for (int tries = 0; tries < kTries; ++tries) {
      const auto message = reader_->newest(topic_);
      if (!message) return;
      const auto view = view_of(*message, picture);
      std::span<const std::byte> encoded;
      std::string why;
      if (view) {
        const auto got = state.encoder.encode(*view, state.recipe.kind, state.recipe.cut, state.recipe.options);
        if (got)
          encoded = *got;
        else
          why = got.error().where;
      } else {
        why = "the message holds no picture";
      }
      if (!reader_->holds(*message)) {
        torn_.fetch_add(1, std::memory_order_relaxed);
        continue;
      }
      picture.sequence = message->sequence;
      picture.why = why;
      if (why.empty()) picture.bytes = as_body(encoded, state.recipe.as_part, state.recipe.kind);
      encoded_.fetch_add(1, std::memory_order_relaxed);
      const std::lock_guard lock(state.mutex);
      picture.serial = state.newest.serial + 1;
      state.newest = std::move(picture);
      return;
    }
  }

  /// Its sizes are unknown bytes until the message holds: they are copied once, and the encoder checks them.
  std::optional<images::PixelView> view_of(const tap::Message& message, Picture& picture) const {
    msg::Image head;
    std::memcpy(static_cast<void*>(&head), message.data(), sizeof head);
    picture.stamp_ns = head.stamp.ns;
    if (head.format == msg::PixelFormat::none) return std::nullopt;
    const auto* const pixels = reinterpret_cast<const std::uint8_t*>(message.data() + sizeof head);
    return images::PixelView{{pixels, bulk_bytes_}, head.width, head.height, head.stride, head.format};
  }

  void subscribe(bool wanted) {
    if (wanted == subscribed_) return;
    subscribed_ = wanted;
    const std::string names[] = {name_};
    if (!client_->subscribe(std::span(names, wanted ? 1 : 0))) gone_.store(true, std::memory_order_relaxed);
  }

  const std::unique_ptr<tap::Client> client_;
  const tap::SegmentReader* const reader_;
  const std::uint32_t topic_;
  const std::string name_;
  const std::uint32_t bulk_bytes_;
  std::mutex mutex_;  // of the next four
  std::condition_variable changed_;
  std::list<std::shared_ptr<Place>> places_;
  std::uint64_t looked_ = 0;  // counts viewers
  bool stop_ = false;
  std::atomic<bool> gone_{false};
  std::atomic<std::uint64_t> seen_{0}, encoded_{0}, torn_{0};
  // The thread's alone.
  bool subscribed_ = false, any_ = false;
  std::uint32_t last_ = 0;  // sequence
  hal::Time asked_{};
  std::thread thread_;
};

}  // namespace

std::shared_ptr<ImageStream> ImageStream::open(const std::string& robot, const std::string& topic, std::string& why) {
  auto client = tap::Client::connect(robot, why);
  if (!client) return nullptr;
  const auto reader = (*client)->reader();
  if (!reader) {
    why = fmt::format("the topics of {} cannot be read: {}", robot, hal::to_string(reader.error().code));
    return nullptr;
  }
  std::vector<std::string> pictures;
  std::optional<std::uint32_t> found;
  const auto& topics = (*reader)->topics();
  for (std::uint32_t i = 0; i < topics.size(); ++i) {
    if (!topics[i].known() || topics[i].type != msg::type_info<msg::Image>().name) continue;
    pictures.push_back(topics[i].name);
    if (topics[i].name == topic) found = i;
  }
  if (!found) {
    why = fmt::format("{} has no pictures on topic '{}'; it has them on: {}", robot, topic,
                      pictures.empty() ? "none" : fmt::format("{}", fmt::join(pictures, ", ")));
    return nullptr;
  }
  return std::make_shared<TopicStream>(std::move(*client), *reader, *found);
}

}  // namespace sinew::monitor
