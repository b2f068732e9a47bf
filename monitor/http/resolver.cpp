#include "monitor/http/resolver.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <resolv.h>
#include <sys/socket.h>

#include <memory>
#include <utility>

namespace sinew::monitor {
namespace {

/// Waits for name servers. Empty, with `why`: no address.
std::string look_up(const std::string& host, std::string& why) {
  // Of this thread alone: its default is 10 s for each name server.
  if (res_init() == 0) _res.retrans = 2, _res.retry = 1;
  addrinfo hints{};
  hints.ai_family = AF_INET, hints.ai_socktype = SOCK_STREAM;
  addrinfo* list = nullptr;
  const int error = getaddrinfo(host.c_str(), nullptr, &hints, &list);
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(list, freeaddrinfo);
  char text[INET_ADDRSTRLEN] = "";
  if (error == 0 && list)
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(list->ai_addr)->sin_addr, text, sizeof text);
  if (!*text) why = "no address has the name " + host + (error != 0 ? std::string(": ") + gai_strerror(error) : "");
  return text;
}

}  // namespace

void Resolver::resolve(const std::string& host, Done done) {
  in_addr numeric{};
  if (inet_pton(AF_INET, host.c_str(), &numeric) == 1) return post_([host, done = std::move(done)] { done(host, ""); });
  const auto now = Clock::now();
  std::erase_if(entries_, [&](const auto& e) { return e.second.waiting.empty() && now - e.second.found > kKnownFor; });
  Entry& entry = entries_[host];
  if (entry.waiting.empty() && !entry.address.empty())
    return post_([address = entry.address, done = std::move(done)] { done(address, ""); });
  entry.waiting.push_back(std::move(done));
  if (entry.waiting.size() > 1) return;
  const bool taken = worker_.post([this, host] {
    if (ends_.load(std::memory_order_relaxed)) return;
    std::string why;
    const std::string address = look_up(host, why);
    post_([this, host, address, why] { found(host, address, why); });
  });
  if (!taken) post_([this, host] { found(host, "", "too many names are being looked up"); });
}

void Resolver::found(const std::string& host, const std::string& address, const std::string& why) {
  const auto at = entries_.find(host);
  if (at == entries_.end()) return;
  const std::vector<Done> waiting = std::exchange(at->second.waiting, {});
  at->second.address = address, at->second.found = Clock::now();
  if (address.empty()) entries_.erase(at);
  for (const Done& done : waiting) done(address, why);
}

}  // namespace sinew::monitor
