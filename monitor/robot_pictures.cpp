#include "monitor/robot_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>

#include "hal/platform.hpp"
#include "msg/image.hpp"

namespace sinew::monitor {
namespace {

using namespace std::chrono_literals;

constexpr int kTries = 3;              // to encode a picture in place before it is overwritten
constexpr std::size_t kMostKept = 16;  // recipes of a picture: of one that stands still any number may be asked for
constexpr hal::Duration kLinger = 1s;  // a topic is followed for as long after its last viewer: another may come

/// Its sizes are unknown bytes until the message holds: they are copied once, and the encoder checks them.
images::PixelView pixels_of(const tap::Message& message, const tap::Topic& topic, msg::Image& head) {
  std::memcpy(static_cast<void*>(&head), message.data(), sizeof head);
  const auto* const pixels = reinterpret_cast<const std::uint8_t*>(message.data() + sizeof head);
  return {{pixels, topic.bulk_bytes}, head.width, head.height, head.stride, head.format};
}

bool contains(const std::vector<std::uint32_t>& topics, std::uint32_t topic) {
  return std::find(topics.begin(), topics.end(), topic) != topics.end();
}

}  // namespace

struct RobotPictures::Look final : Viewer {
  Look(std::shared_ptr<RobotPictures> p, std::shared_ptr<Seat> s) : pictures(std::move(p)), seat(std::move(s)) {}
  ~Look() override {
    const std::lock_guard lock(pictures->mutex_);
    std::erase(pictures->seats_, seat);
  }
  void want(const Recipe& recipe) override {
    std::optional<std::uint32_t> last;
    bool is_followed = false;
    {
      const std::lock_guard lock(pictures->mutex_);
      seat->wants = true, seat->recipe = recipe;
      last = seat->last;
      is_followed = contains(pictures->followed_, seat->topic);
    }
    // Where nothing newer is there yet, the message that comes wakes the thread.
    const auto message = pictures->topics_.reader().newest(seat->topic);
    const bool is_next = last && message && message->sequence == *last && is_followed;
    if (!is_next || pictures->topics_.is_gone()) pictures->waiter_.wake();
  }
  const std::shared_ptr<RobotPictures> pictures;
  const std::shared_ptr<Seat> seat;
};

RobotPictures::RobotPictures(RobotTopics& topics) : topics_(topics), waiter_(topics) {
  thread_ = std::thread([this] { serve(); });
}

RobotPictures::~RobotPictures() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  waiter_.wake();
  thread_.join();
}

std::optional<std::uint32_t> RobotPictures::find(std::string_view topic, std::string& why) const {
  std::vector<std::string> names;
  const auto& topics = topics_.reader().topics();
  for (std::uint32_t t = 0; t < topics.size(); ++t) {
    if (topics[t].info != &msg::type_info<msg::Image>()) continue;
    if (topics[t].name == topic) return t;
    names.push_back(topics[t].name);
  }
  why = fmt::format("no pictures on topic '{}'; there are some on: {}", topic,
                    names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")));
  return std::nullopt;
}

std::shared_ptr<RobotPictures::Viewer> RobotPictures::look(std::shared_ptr<RobotPictures> pictures, std::uint32_t topic,
                                                           OnPicture on_picture) {
  auto seat = std::make_shared<Seat>(Seat{topic, std::move(on_picture)});
  {
    const std::lock_guard lock(pictures->mutex_);
    pictures->seats_.push_back(seat);
  }
  return std::make_shared<Look>(std::move(pictures), std::move(seat));
}

RobotPictures::Counters RobotPictures::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

// ---- the picture thread

void RobotPictures::serve() {
  struct Wish {
    std::shared_ptr<Seat> seat;
    Recipe recipe;
    std::optional<std::uint32_t> last;
  };
  std::vector<Wish> wishes;
  std::vector<std::uint32_t> looked_at;
  while (!topics_.is_gone()) {
    waiter_.listen();
    wishes.clear(), looked_at.clear();
    {
      const std::lock_guard lock(mutex_);
      if (stop_) return;
      for (const auto& seat : seats_) {
        looked_at.push_back(seat->topic);
        if (seat->wants) wishes.push_back({seat, seat->recipe, seat->last});
      }
    }
    bool is_new = false;  // somebody waits for a topic that is not followed yet
    for (const Wish& w : wishes)
      if (!serve(*w.seat, w.recipe, w.last)) is_new = is_new || !contains(waiter_.followed(), w.seat->topic);
    const hal::Time now = hal::system_os().now();
    const auto has_viewers = [&](std::uint32_t topic) { return contains(looked_at, topic); };
    if (std::all_of(waiter_.followed().begin(), waiter_.followed().end(), has_viewers) &&
        std::all_of(newest_.begin(), newest_.end(), [&](const auto& n) { return has_viewers(n.first); }))
      forgets_at_.reset();
    else if (!forgets_at_)
      forgets_at_ = now + kLinger;
    if (is_new || (forgets_at_ && now >= *forgets_at_)) {
      waiter_.follow(looked_at);
      {
        const std::lock_guard lock(mutex_);
        followed_ = looked_at;
      }
      std::erase_if(newest_, [&](const auto& n) { return !has_viewers(n.first); });
      forgets_at_.reset();
      continue;  // a message may have come before the robot knew
    }
    waiter_.wait(forgets_at_ ? *forgets_at_ - now : hal::Duration::max());
  }
  end();
}

/// Tells all that there will be nothing more, also those who come later.
void RobotPictures::end() {
  while (true) {
    waiter_.listen();
    Seats all;
    {
      const std::lock_guard lock(mutex_);
      if (stop_) return;
      all = seats_;
    }
    for (const auto& seat : all) seat->on_picture(nullptr);
    all.clear();
    waiter_.wait();
  }
}

/// False: it still wants one.
bool RobotPictures::serve(Seat& seat, const Recipe& recipe, std::optional<std::uint32_t> last) {
  const PicturePtr picture = newest(seat.topic, recipe, last);
  if (!picture) return false;
  {
    // First: with the picture the next one may be asked for.
    const std::lock_guard lock(mutex_);
    seat.wants = false, seat.last = picture->sequence;
  }
  if (seat.on_picture(picture)) return true;
  const std::lock_guard lock(mutex_);
  seat.wants = true;
  return false;
}

/// Null: there is none that is newer than the last one.
RobotPictures::PicturePtr RobotPictures::newest(std::uint32_t topic, const Recipe& recipe,
                                                std::optional<std::uint32_t> last) {
  for (int tries = 0; tries < kTries; ++tries) {
    const auto message = topics_.reader().newest(topic);
    if (!message || last == message->sequence) return nullptr;
    Newest& known = newest_[topic];
    if (known.sequence != message->sequence) known.sequence = message->sequence, known.pictures.clear();
    for (const auto& [r, picture] : known.pictures)
      if (r == recipe) return picture;
    auto picture = encode(*message, recipe);
    if (!picture) continue;
    if (known.pictures.size() == kMostKept) known.pictures.erase(known.pictures.begin());
    known.pictures.emplace_back(recipe, picture);
    return picture;
  }
  return nullptr;
}

/// Null: it was overwritten meanwhile.
RobotPictures::PicturePtr RobotPictures::encode(const tap::Message& message, const Recipe& recipe) {
  msg::Image head;
  const images::PixelView view = pixels_of(message, topics_.reader().topics()[message.topic], head);
  auto picture = std::make_shared<Picture>();
  picture->sequence = message.sequence, picture->stamp_ns = head.stamp.ns;
  picture->published_ns = message.header->published.ns;
  std::span<const std::byte> file;
  if (head.format == msg::PixelFormat::none)
    picture->why = "the message holds no picture";
  else if (const auto encoded = encoder_.encode(view, recipe.kind, recipe.cut, recipe.options))
    file = *encoded;
  else
    picture->why = encoded.error().where;
  const bool holds = topics_.reader().holds(message);
  if (holds && picture->why.empty())
    picture->file = std::make_shared<const std::vector<std::byte>>(file.begin(), file.end());
  const std::lock_guard lock(mutex_);
  ++(holds ? counters_.encoded : counters_.torn);
  return holds ? picture : nullptr;
}

}  // namespace sinew::monitor
