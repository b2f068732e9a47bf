#pragma once
// What a handle of the C interface holds. Inside of the room only.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "client/sinew_client.h"
#include "client/topics.hpp"
#include "hal/result.hpp"
#include "tap/client.hpp"

namespace sinew::client {

/// A failure with its reason in words, as sinew_last_error() gives it.
struct Failure {
  int code = SINEW_IO;
  std::string why;
};
Failure failure(const hal::Error& error, std::string why = {});

/// Everything throws Failure, or what the C++ library throws; the C interface catches both.
/// Thread:  owner, except newest(), holds() and copy(): any.
class Robot {
 public:
  explicit Robot(std::string_view name);

  const tap::Client& client() const { return *client_; }
  const std::vector<Topic>& topics() const { return topics_; }
  const tap::Topic& layout(std::uint32_t topic) const { return reader_->topics()[topic]; }
  /// The only check of numbers that come from C.
  void check_topic(std::uint32_t topic) const;
  std::uint32_t find_topic(std::string_view name) const;

  sinew_message newest(std::uint32_t topic) const;
  sinew_message wait(std::uint32_t topic, hal::Duration timeout);
  sinew_message next(std::uint32_t topic, hal::Duration timeout);
  void wake_at_once(std::uint32_t topic, bool on);
  bool holds(const sinew_message& message) const;
  void copy(const sinew_message& message, std::span<std::byte> into) const;

  /// The reply, good or not; its "ok" is not looked at.
  const std::string& ask(std::string_view request, std::string_view arguments);
  /// Throws what a reply refuses.
  void check_reply() const;
  void now(std::int64_t& now_ns, std::int64_t* offset_ns);
  void get_param(std::string_view module, std::string_view param, sinew_value& value);
  void set_param(std::string_view module, std::string_view param, const sinew_value& value);

  struct Loan {
    std::span<std::byte> message, bulk;
  };
  Loan loan(std::uint32_t topic);
  void send(std::size_t bulk_bytes, std::int64_t stamp_ns, bool wait);
  const std::string& reply() const { return reply_; }

 private:
  struct Follow {  // of one topic
    tap::Cursor cursor;
    bool subscribed = false, at_once = false;
  };
  /// `look` answers true when there is a message; sleeps until then.
  template <class Look>
  sinew_message wait_for(std::uint32_t topic, hal::Duration timeout, Look&& look);
  void subscribe(std::uint32_t topic);
  bool view(const tap::Message& message, sinew_message& out) const;
  void map_loans();

  std::unique_ptr<tap::Client> client_;
  const tap::SegmentReader* reader_ = nullptr;
  std::vector<Topic> topics_;
  std::vector<Follow> follow_;
  std::string reply_, text_;
  std::unique_ptr<hal::SharedMemory> loans_;  // the robot copies from it
  std::uint32_t loaned_ = 0;                  // topic
  bool has_loan_ = false;
};

}  // namespace sinew::client
