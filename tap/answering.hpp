#pragma once
// What answers the requests of a socket: a running robot (Answers), or a recorded one. Only for code that answers
// requests: it shows the JSON library.
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/stream.hpp"
#include "rt/outside_bells.hpp"
#include "tap/request.hpp"
#include "tap/topic_notifier.hpp"

namespace sinew::tap {

/// Topics that other programs read in place.
struct SharedTopics {
  const rt::Segment& segment;
  const hal::SharedMemory* memory;    // of the segment; null: memory that cannot be handed on
  rt::OutsideBells* bells = nullptr;  // that the writers themselves ring, too; null: the writers ring none
};

/// Takes requests apart, and answers those about the topics' memory: memory, doorbells, subscribe. All others are
/// answered by the class derived from it.
/// Thread:  the server's, but for construction.
/// Owner:   segment, memory and bells outlive it.
class Answering {
 public:
  explicit Answering(const SharedTopics& topics) : topics_(topics) {}
  virtual ~Answering() = default;
  Answering(const Answering&) = delete;
  Answering& operator=(const Answering&) = delete;

  /// `text` may be any bytes. `client` names the connection, for subscriptions; memory that came with the request is
  /// taken from its `stream`, null: there is none. Throws bad_alloc and nothing else; so do settle() and
  /// still_waiting().
  Reply answer(std::string_view text, std::uint64_t client, hal::Stream* stream = nullptr);
  /// The reply to a change that took effect; nothing while it waits.
  virtual std::optional<Json> settle(const Change& change) = 0;
  /// The reply to a change that is not waited for any longer.
  virtual Json still_waiting(const Change& change) const = 0;
  /// Follows changes that took effect meanwhile. Called often. Allocates nothing.
  virtual void follow() {}
  /// Call when the client is gone.
  virtual void forget(std::uint64_t client);

  const SharedTopics& shared_topics() const { return topics_; }
  /// Doorbells for the topics. Before the first request; null: there are none.
  void ring_with(TopicNotifier* notifier) { notifier_ = notifier; }
  /// Counters of the socket, for `status`; empty: there is no socket.
  std::function<Json()> outsiders;

 protected:
  struct Bell {
    rt::WriterId writer = 0;
    bool wakes_outsiders = false;  // as the robot file says: clients may ask that the writer itself rings
  };
  /// Whose request is being answered, and the client's connection; null: there is none.
  std::uint64_t client() const { return client_; }
  hal::Stream* stream() const { return stream_; }
  /// Nothing: it knows no such request.
  virtual std::optional<Reply> reply_to(std::string_view name, const Json& request) = 0;
  /// The names of its requests.
  virtual std::vector<std::string> requests() const = 0;
  /// The doorbell of a topic; nothing, with `why`, when there is no such topic.
  virtual std::optional<Bell> bell_of(const std::string& topic, std::string& why) const = 0;

 private:
  Reply reply(std::string_view name, const Json& request);
  Reply memory() const;
  Reply doorbells() const;
  Reply subscribe(const Json& request);
  std::optional<Reply> add_bells(const Json& names, bool at_once, TopicNotifier::Wish& wish, Json& bells) const;

  SharedTopics topics_;
  TopicNotifier* notifier_ = nullptr;
  std::uint64_t client_ = 0;
  hal::Stream* stream_ = nullptr;
};

}  // namespace sinew::tap
