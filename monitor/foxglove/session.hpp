#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "monitor/foxglove/inbox.hpp"
#include "monitor/foxglove/picture_pace.hpp"
#include "monitor/foxglove/protocol.hpp"
#include "monitor/foxglove/robot.hpp"
#include "monitor/http/server.hpp"

namespace sinew::foxglove {

/// One connection of the Foxglove WebSocket protocol: which robots it sees, what it subscribed to, and what it is sent
/// next. Small messages go first, so that plots go on beside pictures; pictures have the pace of PicturePace. What the
/// client leaves lying is bounded by Backlog::kMostBytes, kMostControlBytes and kMostAsked.
/// Thread:  the server's.
class Session final : public monitor::Socket {
 public:
  using Clock = std::chrono::steady_clock;
  struct Options {
    bool sdk = false;          // speaks foxglove.sdk.v1: playback control
    bool may_command = false;  // it has shown the token
    bool all_robots = false;   // names begin with the robot's
    std::string name{}, id{};  // of the server; of this start of it
  };
  /// What a session needs of the server. All are called by its thread, `wake` by any.
  struct Host {
    std::function<void()> wake{};                              // next() has something
    std::function<void(std::chrono::milliseconds)> wake_in{};  // the same, after a time
    std::function<void(std::function<void()>)> post{};         // called by any thread, runs on the server's
    std::function<std::optional<Link>()> link{};
    std::function<Clock::time_point()> now{};
    /// Why this request may not be sent to this robot now; empty: it may. Null: nothing is refused.
    std::function<std::string(const std::string& robot, const std::string& request)> refuses{};
    std::function<void()> closed{};  // the session is being destroyed; null: nobody wants to know
  };

  Session(Options options, Host host);
  ~Session() override;

  /// The robots that it sees from now on. The first call begins the session; a robot of a single one's session that is
  /// not there any more is waited for.
  void follow(const std::vector<std::shared_ptr<Robot>>& robots);
  /// Call ten times a second: parameters, time and playback are looked after.
  void tick();

  bool receive(bool binary, std::span<const std::byte> message) override;
  std::optional<Message> next() override;

  static constexpr std::size_t kMostControlBytes = 2 << 20, kMostAsked = 64, kMostClientChannels = 256;
  static constexpr std::size_t kSmallMessages = 2000;  // of a topic that wait for this connection
  static constexpr unsigned kMostGarbage = 8;          // messages that are none

 private:
  struct Seen {  // a robot
    std::shared_ptr<Robot> robot;
    std::string prefix;  // "" or "/quad"
    std::vector<std::uint32_t> channels{}, services{};
  };
  struct ChannelRef {
    std::shared_ptr<Robot> robot;
    std::size_t index;
  };
  struct ServiceRef {
    std::shared_ptr<Robot> robot;
    std::string request;
  };
  struct Subscription {
    std::uint32_t id, channel;
    Channel::Kind kind;
    bool is_small;
    std::shared_ptr<Inbox> inbox;
    std::shared_ptr<void> feed{};
    std::shared_ptr<PictureTap> pictures{};
    bool wanted = false;  // a picture
  };
  struct ClientChannel {
    std::shared_ptr<Robot> robot;
    std::string topic;
  };
  enum class After : std::uint8_t { asked, written, followed };  // why parameters are read
  struct Reading;                                                // parameters that are being asked for
  struct Writing;

  void begin();
  void appear(const std::shared_ptr<Robot>& robot);
  void disappear(Seen& seen);
  void send(std::string text);
  void send(std::vector<std::byte> bytes);
  void complain(StatusLevel level, const std::string& message) { send(status(level, message)); }
  /// `done` runs on the server's thread, if the session is still there. False: too much is asked already.
  using Answered = std::function<void(const std::string& reply)>;
  bool ask(const std::shared_ptr<Robot>& robot, std::string request, std::string arguments, Answered done);
  /// `recent`: a status that others have asked for will do.
  bool ask_status(const std::shared_ptr<Robot>& robot, bool recent, Answered done);
  Robot::Done here(Answered done);
  std::string why_not(const std::shared_ptr<Robot>& robot, const std::string& request) const;

  void handle(const Subscribe& message);
  void subscribe(std::uint32_t id, std::uint32_t channel);
  void handle(const Unsubscribe& message);
  void handle(const ClientAdvertise& message);
  void handle(const ClientUnadvertise& message);
  void handle(const GetParameters& message);
  void handle(const SetParameters& message);
  void handle(const FollowParameters& message);
  void handle(const FollowGraph& message);
  void handle(const FetchAsset& message);
  void handle(const ClientData& message);
  void handle(const ServiceCall& message);
  void handle(const PlaybackControl& message);

  /// The robot that a name begins with, and the rest of it.
  Seen* find(std::string_view name, std::string_view& rest);
  void read_parameters(std::vector<std::string> names, std::optional<std::string> id, After after);
  void parameters_read(const Reading& reading);
  void write_next(const std::shared_ptr<Writing>& writing);
  void look_at_followed_parameters();
  void send_graph(const GraphUpdate& update) { send(graph_update(update)); }
  void add_graph(const Seen& seen, GraphUpdate& update) const;
  void playback_looked(const std::string& reply, const std::string& request, bool did_seek);

  bool holds_small();
  std::optional<Message> small_message();
  std::optional<Message> large_message();
  std::optional<Message> picture();
  /// The next one from these subscriptions in turn.
  template <class Which>
  std::optional<Message> in_turn(std::size_t& next, const Which& which);

  const Options options_;
  const Host host_;
  const std::shared_ptr<Backlog> backlog_;
  const std::shared_ptr<char> alive_ = std::make_shared<char>();
  bool begun_ = false;
  std::vector<Seen> robots_;
  std::uint32_t last_channel_ = 0, last_service_ = 0;
  std::map<std::uint32_t, ChannelRef> channels_;
  std::map<std::uint32_t, ServiceRef> services_;
  std::vector<Subscription> subscriptions_;
  std::map<std::uint32_t, ClientChannel> client_channels_;
  std::deque<Message> control_;
  std::size_t control_bytes_ = 0, asked_ = 0;
  bool overflowed_ = false;  // the client asked for more than it takes
  unsigned garbage_ = 0;

  std::set<std::string> followed_parameters_;
  std::map<std::string, std::string> known_parameters_;  // value as it was sent last
  bool follows_graph_ = false;
  unsigned ticks_ = 0;
  bool looks_at_parameters_ = false, looks_at_playback_ = false;
  std::uint64_t told_time_ = 0;
  std::optional<PlaybackState> told_playback_;

  PicturePace pace_;
  bool picture_being_sent_ = false;
  std::optional<Clock::time_point> woken_at_{};  // by wake_in()
  std::size_t next_small_ = 0, next_large_ = 0, next_picture_ = 0;
  unsigned small_in_row_ = 0;
  bool is_far_ = false;
  std::optional<Clock::time_point> small_at_{};  // the last one of a bundle
  Clock::time_point small_woken_{};              // a wake_in() for the next bundle ends then
};

}  // namespace sinew::foxglove
