#include "net/service.hpp"

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

#include "hal/linux/run_dir.hpp"

namespace sinew::net {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kTick = 100ms;
/// Endpoints come within milliseconds of their participant, where both hear each other.
constexpr hal::Duration kSilentFor = 6s;
constexpr std::size_t kMostNotes = 20, kMostListed = 50, kMostTold = 500;

hal::Time monotonic_now() {
  timespec ts{};
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return {std::int64_t{ts.tv_sec} * 1'000'000'000 + ts.tv_nsec};
}

template <class T, class Use>
void first_of(const std::vector<T>& all, const Use& use) {
  for (std::size_t i = 0; i < all.size() && i < kMostListed; ++i) use(all[i]);
}

}  // namespace

std::string robot_in(const std::string& user_data) {
  constexpr std::string_view kKey = "sinew=";
  const std::size_t at = user_data.find(kKey);
  if (at == std::string::npos || (at > 0 && user_data[at - 1] != ';')) return {};
  const std::size_t begin = at + kKey.size();
  std::string name = user_data.substr(begin, std::min(user_data.find(';', begin), begin + 40) - begin);
  for (char& c : name)
    if (c < ' ' || c > '~') c = '?';
  return name;
}

hal::Duration Service::pause_after(int attempt) {
  hal::Duration pause = kFirstPause;
  for (int i = 0; i < attempt && pause < kMostPause; ++i) pause *= 2;
  return std::min(pause, kMostPause);
}

Service::Service(ServiceOptions options, LocalLink& link, std::vector<std::unique_ptr<Part>> parts)
    : options_(std::move(options)), link_(link), parts_(std::move(parts)), watch_(options_.dds.interfaces) {
  link_.on_ask([this] { return status(); });
}

Service::~Service() {
  parts_.clear();  // before their participant
}

void Service::note(const std::string& line) {
  log_.push_back(line);
  if (log_.size() > kMostNotes) log_.pop_front();
  if (options_.say) options_.say(line);
}

bool Service::open() {
  ParticipantOptions dds = options_.dds;
  dds.user_data = "sinew=" + options_.robot + ";" + dds.user_data;
  std::string why;
  if (watch_.at_start().empty() && !dds.interfaces.empty()) {
    trouble_ = "no network: there is no address on";
    for (const std::string& one : dds.interfaces) trouble_ += " '" + one + "'";
    return false;
  }
  auto opened = Participant::open(dds, why);
  if (!opened) {
    trouble_ = why;
    return false;
  }
  participant_ = std::move(*opened);
  for (const auto& part : parts_)
    if (!part->start(*participant_, why)) {
      trouble_ = why;
      return false;
    }
  if (dds.multicast) others_.emplace(dds.domain, watch_.at_start());
  return true;
}

Service::End Service::run() {
  begin_ = monotonic_now();
  if (options_.alive) options_.alive();
  const bool is_open = open();
  if (options_.alive) options_.alive();
  const hal::Time again = begin_ + pause_after(options_.attempt);
  if (is_open) {
    std::string on;
    for (const std::string& one : watch_.at_start()) on += (on.empty() ? " on " : ", ") + one;
    note("DDS domain " + std::to_string(options_.dds.domain) + (on.empty() ? " on this machine only" : on));
  } else {
    note(trouble_ + "; tried again in " + std::to_string(pause_after(options_.attempt) / 1ms) +
         " ms, or when an address comes");
  }
  link_.set_state(trouble_);
  for (const auto& part : parts_) part->set_trouble(trouble_);
  while (!options_.stop()) {
    wait();
    const hal::Time now = monotonic_now();
    if (watch_.changed(now)) {
      std::string is;
      for (const std::string& one : network_addresses(options_.dds.interfaces)) is += (is.empty() ? "" : ", ") + one;
      note("addresses have changed: " + (is.empty() ? "none" : is) + "; DDS begins anew");
      return End::anew;
    }
    if (!is_open && now >= again) return End::failed;
    if (participant_) participant_->begin_look();
    link_.look();
    if (is_open)
      for (const auto& part : parts_) part->look(now);
    if (now >= second_) second_ = now + 1s, look_each_second(now);
  }
  return End::stopped;
}

void Service::wait() {
  std::vector<pollfd> fds;
  if (watch_.fd() >= 0) fds.push_back({watch_.fd(), POLLIN, 0});
  if (participant_) fds.push_back({participant_->wake_fd(), POLLIN, 0});
  link_.add_fds(fds);
  for (const auto& part : parts_) part->add_fds(fds);
  poll(fds.data(), fds.size(), static_cast<int>(kTick / 1ms));
}

void Service::look_each_second(hal::Time now) {
  if (options_.alive) options_.alive();
  for (const std::string& line : take_dds_log()) note("Cyclone DDS: " + line);
  if (!participant_) return;
  if (others_) others_->look(now);
  participants_ = participant_->participants();
  look_for_unmatched();
  look_for_one_way(now);
}

std::string Service::name_of(const Guid& participant) const {
  for (const RemoteParticipant& p : participants_)
    if (p.guid == participant) {
      const std::string robot = robot_in(p.user_data);
      return robot.empty() ? "" : " of the robot " + robot;
    }
  return {};
}

void Service::look_for_unmatched() {
  unmatched_.clear();
  std::vector<OwnEndpoint> own;
  for (const auto& part : parts_) {
    std::vector<OwnEndpoint> more = part->endpoints();
    own.insert(own.end(), more.begin(), more.end());
  }
  for (const RemoteEndpoint& remote : participant_->endpoints()) {
    silent_since_.erase(remote.participant);
    for (const OwnEndpoint& mine : own) {
      if (!is_counterpart(mine, remote)) continue;
      const std::string why = why_no_match(mine, remote);
      if (why.empty()) continue;
      unmatched_.push_back({remote.topic, why, remote.guid, remote.participant, remote.writes});
      const std::string line = remote.topic + ": the " + (remote.writes ? "writer " : "reader ") +
                               to_text(remote.guid) + name_of(remote.participant) + " does not match: " + why;
      if (told_.size() < kMostTold && told_.insert(line).second) note(line);
    }
  }
}

/// A participant that is heard and never tells its endpoints does not hear us: those are told only to whom it knows.
void Service::look_for_one_way(hal::Time now) {
  std::map<Guid, hal::Time> silent;
  const std::vector<RemoteEndpoint> endpoints = participant_->endpoints();
  for (const RemoteParticipant& p : participants_) {
    const bool tells = std::any_of(endpoints.begin(), endpoints.end(),
                                   [&](const RemoteEndpoint& e) { return e.participant == p.guid; });
    if (tells || robot_in(p.user_data).empty()) continue;  // others may have no endpoint
    const auto before = silent_since_.find(p.guid);
    silent[p.guid] = before == silent_since_.end() ? now : before->second;
  }
  silent_since_ = std::move(silent);
  std::string text;
  for (const auto& [guid, since] : silent_since_)
    if (now - since >= kSilentFor)
      text += (text.empty() ? "" : "\n") + std::string("DDS of the robot ") +
              robot_in(std::find_if(participants_.begin(), participants_.end(),
                                    [g = guid](const RemoteParticipant& p) { return p.guid == g; })
                           ->user_data) +
              " is heard and does not hear us";
  if (text != trouble_) {
    if (!text.empty()) note(text);
    trouble_ = text;
    link_.set_state(trouble_);
    for (const auto& part : parts_) part->set_trouble(trouble_);
  }
}

std::string Service::status() const {
  using nlohmann::json;
  const hal::Time now = monotonic_now();
  json j = {{"robot", options_.robot},
            {"pid", hal::process_id()},
            {"domain", options_.dds.domain},
            {"open", participant_ != nullptr},
            {"trouble", trouble_},
            {"failed_before", options_.attempt},
            {"since_s", msg::seconds(now - begin_)},
            {"secure", options_.dds.security.used()},
            {"addresses", watch_.at_start()},
            {"participants", json::array()},
            {"unmatched", json::array()},
            {"log", log_}};
  first_of(participants_, [&](const RemoteParticipant& p) {
    j["participants"].push_back({{"guid", to_text(p.guid)}, {"robot", robot_in(p.user_data)}});
  });
  first_of(unmatched_, [&](const Unmatched& u) {
    j["unmatched"].push_back({{"topic", u.topic},
                              {"endpoint", to_text(u.endpoint)},
                              {"is", u.writes ? "writer" : "reader"},
                              {"of", name_of(u.participant)},
                              {"why", u.why}});
  });
  if (others_) {
    j["other_domains"] = json::array();
    for (const OtherDomains::Heard& h : others_->heard(now))
      j["other_domains"].push_back({{"domain", h.domain}, {"address", h.address}, {"vendor", h.vendor}});
  } else {
    j["other_domains"] = nullptr;  // not known
  }
  for (const auto& part : parts_) part->add_status(j);
  return j.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace sinew::net
