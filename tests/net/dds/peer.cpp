// dds_peer DOMAIN INTERFACE [security=FOLDER,MEMBER] ENDPOINT...: a participant that is not ours, with endpoints of
// these kinds, until its input ends. ENDPOINT: read,TOPIC,TYPE or write,TOPIC,TYPE, with reliable, transient_local,
// partition=NAME or deadline_ms=N behind it, by commas. Of each sample that comes it prints the letters, a line each.
#include <poll.h>
#include <unistd.h>

#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "net/dds/participant.hpp"

using namespace sinew;

namespace {

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  return words;
}

std::string value_of(const std::string& word, const std::string& key) {
  return word.rfind(key + "=", 0) == 0 ? word.substr(key.size() + 1) : std::string();
}

[[noreturn]] void die(const std::string& why) {
  std::fprintf(stderr, "dds_peer: %s\n", why.c_str());
  std::exit(2);
}

/// The files of tests/net/dds/make_security.sh.
net::DdsSecurity security_of(const std::string& folder, const std::string& member) {
  const std::string own = folder + "/" + member;
  return {folder + "/ca.pem", own + ".pem", own + ".key", folder + "/ca.pem", folder + "/governance.p7s", own + ".p7s"};
}

net::EndpointSpec spec_of(const std::vector<std::string>& words) {
  if (words.size() < 3) die("an endpoint is read,TOPIC,TYPE or write,TOPIC,TYPE");
  net::EndpointSpec spec{words[1], words[2], {}, {}};
  spec.qos.depth = 100;
  for (std::size_t i = 3; i < words.size(); ++i) {
    const std::string &word = words[i], partition = value_of(word, "partition"),
                      deadline = value_of(word, "deadline_ms");
    if (word == "reliable")
      spec.qos.reliable = true;
    else if (word == "transient_local")
      spec.qos.transient_local = true;
    else if (!partition.empty())
      spec.qos.partitions = {partition};
    else if (!deadline.empty())
      spec.qos.deadline = std::chrono::milliseconds(std::atoi(deadline.c_str()));
    else
      die("not of an endpoint: " + word);
  }
  return spec;
}

void print_letters(const std::vector<std::uint8_t>& cdr) {
  for (const std::uint8_t byte : cdr)
    if (std::isprint(byte) != 0) std::putchar(byte);
  std::putchar('\n');
  std::fflush(stdout);
}

bool input_ended() {
  pollfd in{STDIN_FILENO, POLLIN, 0};
  char byte = 0;
  return poll(&in, 1, 0) == 1 && read(STDIN_FILENO, &byte, 1) <= 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) die("DOMAIN INTERFACE ENDPOINT...");
  net::ParticipantOptions options;
  options.domain = static_cast<std::uint32_t>(std::atoi(argv[1]));
  options.interfaces = {argv[2]};
  std::vector<std::vector<std::string>> endpoints;
  for (int i = 3; i < argc; ++i) {
    const std::string secure = value_of(argv[i], "security");
    if (secure.empty())
      endpoints.push_back(words_of(argv[i]));
    else
      options.security = security_of(words_of(secure).at(0), words_of(secure).at(1));
  }
  std::string why;
  const auto participant = net::Participant::open(options, why);
  if (!participant) die(why);
  std::vector<std::unique_ptr<net::DdsReader>> readers;
  std::vector<std::unique_ptr<net::DdsWriter>> writers;
  for (const auto& words : endpoints) {
    if (words.front() == "write") {
      auto writer = (*participant)->write(spec_of(words), why);
      if (!writer) die(why);
      writers.push_back(std::move(*writer));
    } else {
      auto reader = (*participant)->read(spec_of(words), why);
      if (!reader) die(why);
      readers.push_back(std::move(*reader));
    }
  }
  net::DdsSample sample;
  while (!input_ended()) {
    pollfd fds[2] = {{(*participant)->wake_fd(), POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}};
    poll(fds, 2, 1000);
    (*participant)->begin_look();
    for (const auto& reader : readers)
      while (reader->take(sample)) print_letters(sample.cdr);
  }
  return 0;
}
