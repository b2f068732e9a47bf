// The socket in front of something else than a running robot.
#include "tap/answering.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "rt/commit.hpp"
#include "tap_rig.hpp"

namespace sinew::tap::answering_test {
namespace {

OwnRunDir g_answering_run_dir;

/// One topic of ranges in shared memory.
class Ranges {
 public:
  Ranges() {
    rt::SegmentPlan plan;
    const rt::WriterId writer = plan.add_writer("tof");
    plan.add_topic(writer, {.name = "tof.range", .type = &msg::type_info<msg::RangeSample>(), .history = 4});
    memory = std::move(*hal::system_os().shared_memory("ranges", plan.bytes()));
    segment.emplace(plan, *memory);
    commit_.emplace(*segment, writer);
  }
  void publish(double range_m) {
    static_cast<msg::RangeSample*>(commit_->try_loan(0))->range_m = range_m;
    commit_->commit({});
  }
  std::unique_ptr<hal::SharedMemory> memory;
  std::optional<rt::Segment> segment;

 private:
  std::optional<rt::Commit> commit_;
};

/// Knows three requests; `work` waits until the test ends it.
class Bench final : public Answering {
 public:
  Bench(const SharedTopics& topics, const std::atomic<bool>& is_done) : Answering(topics), is_done_(is_done) {}
  std::optional<Json> settle(const Change& change) override {
    EXPECT_EQ(change.number, 5u);
    if (!is_done_) return std::nullopt;
    Json reply = change.reply;
    reply["done"] = true;
    return reply;
  }
  Json still_waiting(const Change& change) const override {
    Json reply = change.reply;
    reply.update(refused(hal::Errc::timeout, "it takes long"));
    return reply;
  }

 private:
  std::optional<Reply> reply_to(std::string_view name, const Json& request) override {
    if (name == "hello") return good({{"version", kProtocolVersion}, {"robot", "bench"}, {"pid", 7}});
    if (name == "echo") return good({{"text", request.value("text", "")}});
    if (name == "count") return good({{"clients", outsiders()["clients"]}});
    if (name != "work") return std::nullopt;
    Reply reply = good();
    reply.change = {{}, std::move(reply.json), 5};
    return reply;
  }
  std::vector<std::string> requests() const override { return {"hello", "echo", "count", "work"}; }
  std::optional<Bell> bell_of(const std::string& topic, std::string& why) const override {
    if (topic == "tof.range") return Bell{.writer = 0, .wakes_outsiders = true};
    why = "no topic " + topic;
    return std::nullopt;
  }
  const std::atomic<bool>& is_done_;
};

class AnsweringTest : public testing::Test {
 protected:
  void open(const ServerLimits& limits = {}, bool shared = true) {
    std::string why;
    name_ = std::move(*Name::take("bench", why));
    auto answering =
        std::make_unique<Bench>(SharedTopics{*ranges.segment, shared ? ranges.memory.get() : nullptr}, is_done);
    auto opened = Server::open(*name_, std::move(answering), hal::system_os(), limits);
    ASSERT_TRUE(opened) << opened.error().where;
    server_ = std::move(*opened);
    auto connected = Client::connect("bench", why);
    ASSERT_TRUE(connected) << why;
    client = std::move(*connected);
  }
  Ranges ranges;
  std::atomic<bool> is_done{false};

 private:
  std::unique_ptr<Name> name_;
  std::unique_ptr<Server> server_;

 protected:
  std::unique_ptr<Client> client;
};

TEST_F(AnsweringTest, ItsOwnRequestsAreAnsweredAndOthersAreRefusedWithANameThatIsNear) {
  open();
  EXPECT_EQ(ask(*client, "echo", {{"text", "a"}, {"id", 9}}), Json({{"ok", true}, {"text", "a"}, {"id", 9}}));
  EXPECT_EQ(ask(*client, "count")["clients"], 1);
  EXPECT_EQ(ask(*client, "ecko")["error"]["why"], "no request \"ecko\" in this version; did you mean echo?");
  EXPECT_EQ(ask(*client, "memori")["error"]["why"], "no request \"memori\" in this version; did you mean memory?");
}

TEST_F(AnsweringTest, ItsTopicsAreReadInPlaceAndRingTheirBells) {
  open();
  const auto reader = client->reader();
  ASSERT_TRUE(reader);
  const auto topic = *(*reader)->find("tof.range");
  const std::string name = "tof.range";
  ASSERT_TRUE(client->subscribe({&name, 1}));
  const std::uint32_t before = client->bell(topic);
  ranges.publish(1.5);
  while (client->bell(topic) == before) client->wait(topic, before, hal::system_os().now() + 1s);
  const auto message = (*reader)->newest(topic);
  ASSERT_TRUE(message);
  EXPECT_EQ(reinterpret_cast<const msg::RangeSample*>(message->data())->range_m, 1.5);
  EXPECT_EQ(ask(*client, "subscribe", {{"topics", {"tof.rang"}}})["error"]["why"], "no topic tof.rang");
}

TEST_F(AnsweringTest, WritersThatRingNoBellsLeaveThoseOfAtOnceToThePeriod) {
  open();
  const auto topic = *(*client->reader())->find("tof.range");
  const std::string name = "tof.range";
  EXPECT_EQ(ask(*client, "subscribe", {{"topics", Json::array()}, {"at_once", {name}}})["bells"], Json({{name, 0}}));
  const std::uint32_t before = client->bell(topic);
  ranges.publish(1.5);
  while (client->bell(topic) == before) client->wait(topic, before, hal::system_os().now() + 1s);
  EXPECT_TRUE((*client->reader())->newest(topic));
}

TEST_F(AnsweringTest, WithoutSharedMemoryThereIsNothingToMap) {
  open({}, false);
  for (const char* request : {"memory", "doorbells", "subscribe"})
    EXPECT_EQ(ask(*client, request, {{"topics", Json::array()}})["error"]["code"], "not_supported") << request;
}

TEST_F(AnsweringTest, TheReplyToWorkComesWhenItIsDone) {
  open();
  std::thread worker([this] { is_done = true; });
  EXPECT_EQ(ask(*client, "work", {{"id", 3}}), Json({{"ok", true}, {"id", 3}, {"done", true}}));
  worker.join();
}

TEST_F(AnsweringTest, WorkThatTakesTooLongIsAnsweredAndGoesOn) {
  open({.patience = 50ms});
  EXPECT_EQ(ask(*client, "work")["error"]["code"], code_name(hal::Errc::timeout));
  is_done = true;
  EXPECT_EQ(ask(*client, "work")["done"], true);
}

}  // namespace
}  // namespace sinew::tap::answering_test
