#include "monitor/http/server.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <mutex>
#include <thread>

#include "http_client.hpp"
#include "monitor/http/path.hpp"
#include "monitor/http/resolver.hpp"

namespace sinew::monitor::server_test {
namespace {

using test::HttpClient;
using test::Reply;
using namespace std::chrono_literals;

/// A server whose requests are answered by the test.
class Rig {
 public:
  explicit Rig(Server::OnRequest on_request, ServerOptions options = {}, Server::OnSocket on_socket = nullptr) {
    options.port = 0;
    if (!on_socket)
      on_socket = [](const Request&, ConnectionId, Response& refusal) {
        refusal = plain(404, "none");
        return nullptr;
      };
    std::string why;
    server = Server::open(options, std::move(on_request), std::move(on_socket), why);
    if (!server) {
      ADD_FAILURE() << why;
      return;
    }
    thread_ = std::thread([this] { server->run(); });
  }
  ~Rig() {
    if (!server) return;
    server->stop();
    thread_.join();
  }
  std::uint16_t port() const { return server->port(); }
  std::unique_ptr<Server> server;

 private:
  std::thread thread_;
};

/// Says what it was asked.
void echo(const Request& r, ConnectionId, const Server::Reply& reply) {
  std::string text = r.method + " " + r.path;
  for (const auto& [name, value] : r.query) text.append(" ").append(name).append("=").append(value);
  reply(plain(200, text + " [" + r.body + "]"));
}

TEST(HttpServer, AnswersOneRequestAfterTheOtherOnOneConnection) {
  Rig rig(echo);
  HttpClient client(rig.port());
  EXPECT_EQ(client.get("/a/b?x=1&y=two%20words&z").body, "GET /a/b x=1 y=two words z= []\n");
  EXPECT_EQ(client.post("/c", "{\"k\": 1}", "").body, "POST /c [{\"k\": 1}]\n");
  const Reply head = client.ask("HEAD", "/d");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-length"), "11");
  EXPECT_EQ(client.get("/e").body, "GET /e []\n");
  EXPECT_EQ(rig.server->counters().accepted, 1u);
}

/// Always has the next message, as a busy robot has.
class Flood final : public Socket {
 public:
  bool receive(bool, std::span<const std::byte>) override { return true; }
  std::optional<Message> next() override {
    if (left_ == 0) return std::nullopt;
    Message message;
    message.binary = true;
    message.bytes = bytes_of(std::string(500, --left_ == 0 ? 'z' : 'm'));
    return message;
  }

 private:
  unsigned left_ = 10'000;
};

// The system may hold back small packets for 200 ms: a twentieth of these would take longer than the client's patience.
TEST(HttpServer, ManySmallMessagesWaitForNoTimer) {
  Rig rig(echo, {.subprotocols = {"p"}},
          [](const Request&, ConnectionId, Response&) { return std::make_unique<Flood>(); });
  HttpClient client(rig.port());
  client.send("GET /x HTTP/1.1\r\nHost: " + client.host() +
              "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
              "Sec-WebSocket-Protocol: p\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
  EXPECT_TRUE(client.wait_for("101 Switching Protocols"));
  EXPECT_TRUE(client.wait_for(std::string(500, 'z')));
}

TEST(HttpServer, ALargeBodyArrivesWhole) {
  std::string large(5'000'000, 'x');
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>('a' + i % 23);
  Rig rig([&](const Request&, ConnectionId, const Server::Reply& reply) {
    Response r;
    r.body = bytes_of(large);
    reply(std::move(r));
  });
  HttpClient client(rig.port());
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(client.get("/").body == large);
}

TEST(HttpServer, AReplyMayComeLaterFromAnotherThread) {
  std::thread later;
  Rig rig([&](const Request&, ConnectionId, const Server::Reply& reply) {
    later = std::thread([reply] {
      std::this_thread::sleep_for(20ms);
      reply(plain(200, "late"));
      reply(plain(500, "twice"));  // only the first counts
    });
  });
  HttpClient client(rig.port());
  EXPECT_EQ(client.get("/").body, "late\n");
  later.join();
}

TEST(HttpServer, ARequestThatNobodyAnswersIsRefused) {
  Rig rig([](const Request&, ConnectionId, const Server::Reply&) {});
  HttpClient client(rig.port());
  EXPECT_EQ(client.get("/").status, 503);
}

TEST(HttpServer, RefusesWhatIsNoRequestOfOurs) {
  Rig rig(echo);
  const auto status = [&](const std::string& text) {
    HttpClient client(rig.port());
    client.send(text);
    return client.reply().status;
  };
  const std::string host = "Host: 127.0.0.1\r\n";
  EXPECT_EQ(status("GET /a%5cb HTTP/1.1\r\n" + host + "\r\n"), 400);
  EXPECT_EQ(status("POST / HTTP/1.1\r\n" + host + "Content-Length: 65537\r\n\r\n"), 413);
  EXPECT_EQ(status("POST / HTTP/1.1\r\n" + host + "Transfer-Encoding: chunked\r\n\r\n"), 411);
  EXPECT_EQ(status("GET /?" + std::string(2000, 'q') + " HTTP/1.1\r\n" + host + "\r\n"), 400);
  // Neither: the connection simply ends.
  HttpClient nonsense(rig.port());
  nonsense.send("\x16\x03\x01 nonsense\r\n\r\n");
  EXPECT_TRUE(nonsense.is_ended());
  HttpClient long_head(rig.port());
  long_head.send("GET / HTTP/1.1\r\n" + host + "X: " + std::string(20'000, 'h'));
  EXPECT_TRUE(long_head.is_ended());
}

TEST(HttpServer, APathLeavesNoFolder) {
  Rig rig(echo);
  for (const char* path : {"/../etc/passwd", "/%2e%2e/etc/passwd", "/a/..%2f..%2fetc/passwd", "/./a", "/a/%2e/b"}) {
    HttpClient client(rig.port());
    const Reply r = client.get(path);
    EXPECT_TRUE(r.status == 400 || r.status == 403 || r.body.find("..") == std::string::npos) << path << ": " << r.body;
  }
  EXPECT_TRUE(is_plain_path("/"));
  EXPECT_TRUE(is_plain_path("/quad/images/camera.raw.jpg"));
  EXPECT_TRUE(is_plain_path("/folder/"));
  for (const char* path : {"", "a", "//", "/a//b", "/..", "/a/../b", "/a/.", "/a\\b", "/a\nb"})
    EXPECT_FALSE(is_plain_path(path)) << path;
}

TEST(HttpServer, APeerThatDoesNotFinishItsRequestIsClosed) {
  ServerOptions options;
  options.patience = 1s;
  Rig rig(echo, options);
  HttpClient head(rig.port()), body(rig.port()), nothing(rig.port());
  head.send("GET / HTTP/1.1\r\nHo");
  body.send("POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 10\r\n\r\nabc");
  EXPECT_TRUE(head.is_ended());
  EXPECT_TRUE(body.is_ended());
  EXPECT_TRUE(nothing.is_ended());
  EXPECT_EQ(HttpClient(rig.port()).get("/").status, 200);
}

TEST(HttpServer, APeerThatTakesNothingIsClosedAndTheOthersAreServed) {
  const std::string large(8'000'000, 'x');
  ServerOptions options;
  options.patience = 1s;
  Rig rig(
      [&](const Request& r, ConnectionId, const Server::Reply& reply) {
        Response response;
        response.body = bytes_of(r.path == "/large" ? large : std::string("small"));
        reply(std::move(response));
      },
      options);
  HttpClient stalled(rig.port());
  stalled.send("GET /large HTTP/1.1\r\nHost: x\r\n\r\n");
  HttpClient good(rig.port());
  EXPECT_EQ(good.get("/").body, "small");
  const auto until = std::chrono::steady_clock::now() + 10s;
  while (rig.server->counters().open > 1 && std::chrono::steady_clock::now() < until)
    EXPECT_EQ(good.get("/").body, "small");
  EXPECT_EQ(rig.server->counters().open, 1u);
}

TEST(HttpServer, ConnectionsOfOnePeerAreBounded) {
  ServerOptions options;
  options.most_per_peer = 4;
  std::vector<Server::Reply> waiting;  // the server's thread
  Rig rig(
      [&](const Request& r, ConnectionId, const Server::Reply& reply) {
        if (r.path == "/later")
          waiting.push_back(reply);
        else
          reply(plain(200, "now"));
      },
      options);
  std::vector<std::unique_ptr<HttpClient>> clients;
  for (int i = 0; i < 4; ++i) {
    clients.push_back(std::make_unique<HttpClient>(rig.port()));
    clients.back()->send("GET /later HTTP/1.1\r\nHost: x\r\n\r\n");
  }
  const auto until = std::chrono::steady_clock::now() + 10s;
  while (rig.server->counters().requests < 4 && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(1ms);
  HttpClient fifth(rig.port());  // all four have a request
  EXPECT_EQ(fifth.get("/").status, 0);
  EXPECT_EQ(rig.server->counters().refused_peer, 1u);
  rig.server->post([&] {
    for (const auto& reply : waiting) reply(plain(200, "later"));
    waiting.clear();
  });
  for (const auto& client : clients) EXPECT_EQ(client->reply().body, "later\n");
  HttpClient sixth(rig.port());  // takes the place of an idle one
  EXPECT_EQ(sixth.get("/").status, 200);
  EXPECT_EQ(rig.server->counters().made_room, 1u);
  EXPECT_TRUE(clients.front()->is_ended());
  EXPECT_EQ(clients.back()->get("/").status, 200);
}

TEST(HttpServer, AStreamSendsItsPiecesAsTheyCome) {
  struct Numbers final : Stream {
    std::atomic<int>* ready;
    std::atomic<bool>* ended;
    int given = 0;
    ~Numbers() override { ended->store(true); }
    std::optional<Piece> next() override {
      if (given == ready->load()) return std::nullopt;
      return Piece{"<", bytes_of(std::to_string(++given)), ">"};
    }
    bool is_over() const override { return given == 3; }
  };
  std::atomic<int> ready{1};
  std::atomic<bool> ended{false};
  std::atomic<std::uint32_t> connection{0};
  Rig rig([&](const Request&, ConnectionId id, const Server::Reply& reply) {
    auto numbers = std::make_unique<Numbers>();
    numbers->ready = &ready, numbers->ended = &ended;
    connection = static_cast<std::uint32_t>(id);
    Response r;
    r.stream = std::move(numbers);
    reply(std::move(r));
  });
  HttpClient client(rig.port());
  client.send("GET / HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_TRUE(client.wait_for("<1>"));
  ready = 3;
  rig.server->wake(connection);
  EXPECT_TRUE(client.wait_for("<2><3>"));
  EXPECT_TRUE(client.is_ended());
  const auto until = std::chrono::steady_clock::now() + 10s;
  while (!ended && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(ended);
}

TEST(HttpServer, APeerThatLeavesWhileItsResponseIsMadeIsNoMore) {
  struct Silent final : Stream {
    std::optional<Piece> next() override { return std::nullopt; }
  };
  std::vector<Server::Reply> held;
  Rig rig([&](const Request& r, ConnectionId, const Server::Reply& reply) {
    if (r.path == "/held") return held.push_back(reply);
    Response response;
    response.stream = std::make_unique<Silent>();
    reply(std::move(response));
  });
  for (const char* path : {"/held", "/silent"}) {
    HttpClient client(rig.port());
    client.send(std::string("GET ") + path + " HTTP/1.1\r\nHost: x\r\n\r\n");
    if (path == std::string("/silent")) client.reply(true);
    const auto until = std::chrono::steady_clock::now() + 10s;
    while (rig.server->counters().requests == 0 && std::chrono::steady_clock::now() < until)
      std::this_thread::sleep_for(1ms);
  }
  const auto until = std::chrono::steady_clock::now() + 10s;
  while (rig.server->counters().open > 0 && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(rig.server->counters().open, 0u);
  held.clear();  // an answer needs the server
}

TEST(HttpServer, AMessageOfSomeKilobytesIsNotHeldBackForTheNext) {
  struct Pages final : Socket {
    std::atomic<int>* asked;
    int given = 0;
    bool receive(bool, std::span<const std::byte>) override { return true; }
    std::optional<Message> next() override {
      if (given == asked->load()) return std::nullopt;
      // One large one, or many small ones that are as long together.
      const std::size_t size = given % 100 < 50 ? 6000 : 50;
      return Message{true, bytes_of(std::string(size, '.') + "<" + std::to_string(++given) + ">"), {}};
    }
  };
  std::atomic<int> asked{0};
  std::atomic<std::uint32_t> connection{0};
  Rig rig(echo, {}, [&](const Request&, ConnectionId id, Response&) {
    auto pages = std::make_unique<Pages>();
    pages->asked = &asked;
    connection = static_cast<std::uint32_t>(id);
    return pages;
  });
  HttpClient client(rig.port());
  client.send(
      "GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n");
  ASSERT_EQ(client.reply(true).status, 101);
  // The system gives back what is held back after 200 ms: our patience is over then.
  const auto until = std::chrono::steady_clock::now() + 10s;
  for (int i = 1; i <= 10'000 && std::chrono::steady_clock::now() < until; i += i % 100 < 50 ? 1 : 50) {
    asked = i % 100 < 50 ? i : i + 49;
    rig.server->wake(connection);
    ASSERT_TRUE(client.wait_for("<" + std::to_string(asked) + ">"));
  }
  EXPECT_GE(asked, 9'950);
}

TEST(HttpServer, SaysWhyItCannotListen) {
  Rig rig(echo);
  ServerOptions options;
  options.port = rig.port();
  std::string why;
  EXPECT_EQ(Server::open(options, echo, nullptr, why), nullptr);
  EXPECT_NE(why.find(std::to_string(rig.port())), std::string::npos) << why;
}

/// Calls what a resolver posts, from the thread of the test.
class Posted {
 public:
  void operator()(std::function<void()> what) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(what));
  }
  bool call_one() {
    std::function<void()> what;
    const auto until = std::chrono::steady_clock::now() + 20s;
    while (!what && std::chrono::steady_clock::now() < until) {
      {
        const std::lock_guard lock(mutex_);
        if (!waiting_.empty()) what = std::move(waiting_.front()), waiting_.pop_front();
      }
      if (!what) std::this_thread::sleep_for(1ms);
    }
    if (what) what();
    return static_cast<bool>(what);
  }

 private:
  std::mutex mutex_;
  std::deque<std::function<void()>> waiting_;
};

TEST(Resolver, NumbersNamesAndNamesThatAreNone) {
  Posted posted;
  Resolver resolver([&](std::function<void()> what) { posted(std::move(what)); });
  std::vector<std::string> got;
  const auto look = [&](const std::string& host) {
    resolver.resolve(host, [&, host](const std::string& address, const std::string& why) {
      got.push_back(host + "=" + address + (why.empty() ? "" : "!"));
      EXPECT_EQ(address.empty(), why.find(host) != std::string::npos) << why;
    });
  };
  look("192.168.1.20");
  EXPECT_TRUE(got.empty());
  EXPECT_TRUE(posted.call_one());
  look("localhost"), look("localhost");  // looked up once
  EXPECT_TRUE(posted.call_one());
  look("no-such-host.invalid");
  EXPECT_TRUE(posted.call_one());
  EXPECT_EQ(got, (std::vector<std::string>{"192.168.1.20=192.168.1.20", "localhost=127.0.0.1", "localhost=127.0.0.1",
                                           "no-such-host.invalid=!"}));
}

TEST(Resolver, OneThatEndsTellsNobody) {
  Posted posted;
  bool told = false;
  {
    Resolver resolver([&](std::function<void()> what) { posted(std::move(what)); });
    for (int i = 0; i < 20; ++i)
      resolver.resolve("host" + std::to_string(i) + ".invalid",
                       [&](const std::string&, const std::string&) { told = true; });
  }
  EXPECT_FALSE(told);
}

}  // namespace
}  // namespace sinew::monitor::server_test
