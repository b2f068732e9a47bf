#pragma once
// A WebSocket of a test, as a browser has it.
#include <cstdint>
#include <string>

#include "http_client.hpp"

namespace sinew::monitor::test {

class WebSocket {
 public:
  /// Offers this subprotocol; `more`: further lines of the head, each with its line end; `from`: as HttpClient's.
  WebSocket(std::uint16_t port, const std::string& path, const std::string& subprotocol = "foxglove.websocket.v1",
            const std::string& more = "", std::uint32_t from = 0)
      : http_(port, from) {
    http_.send("GET " + path + " HTTP/1.1\r\nHost: " + http_.host() +
               "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
               "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: " +
               subprotocol + "\r\n" + more + "\r\n");
    status_ = http_.reply().status;
  }
  int status() const { return status_; }
  bool is_open() const { return status_ == 101; }

  struct Message {
    int opcode = 0;  // 1: text, 2: binary, 8: the end; 0: nothing came
    std::string bytes{};
    int code() const {
      return opcode == 8 && bytes.size() >= 2
                 ? static_cast<std::uint8_t>(bytes[0]) << 8 | static_cast<std::uint8_t>(bytes[1])
                 : 0;
    }
    std::string why() const { return bytes.size() > 2 ? bytes.substr(2) : ""; }
  };
  /// The next whole message.
  Message receive(std::chrono::milliseconds patience = 10s) {
    Message m;
    while (true) {
      const std::string head = http_.take(2, patience);
      if (head.size() < 2) return {};
      const int opcode = head[0] & 0x0f;
      std::uint64_t size = head[1] & 0x7f;
      if (size >= 126) {
        const std::string more = http_.take(size == 126 ? 2 : 8, patience);
        size = 0;
        for (const char c : more) size = size << 8 | static_cast<std::uint8_t>(c);
      }
      const std::string bytes = http_.take(size, patience);
      if (bytes.size() < size) return {};
      if (opcode == 9 || opcode == 10) continue;
      if (opcode == 8) return {8, bytes};
      if (opcode != 0) m.opcode = opcode;
      m.bytes += bytes;
      if ((head[0] & 0x80) != 0) return m;
    }
  }
  /// The next message that has this text in it, or the end.
  Message wait_for(const std::string& text) {
    while (true) {
      Message m = receive();
      if (m.opcode == 0 || m.opcode == 8 || m.bytes.find(text) != std::string::npos) return m;
    }
  }
  /// What comes before the end is left out.
  Message end() {
    while (true) {
      Message m = receive();
      if (m.opcode == 0 || m.opcode == 8) return m;
    }
  }
  /// The peer closes it: by a frame that says so, or the connection with it.
  bool is_refused() { return end().opcode == 8 || http_.is_ended(); }
  /// Bytes that need not be a frame.
  void send_raw(const std::string& bytes) { http_.send(bytes); }
  void send(const std::string& bytes, int opcode = 1) {
    std::string frame{static_cast<char>(0x80 | opcode)};
    if (bytes.size() < 126) {
      frame += static_cast<char>(0x80 | bytes.size());
    } else {
      frame += static_cast<char>(0x80 | 127);
      for (int shift = 56; shift >= 0; shift -= 8) frame += static_cast<char>(bytes.size() >> shift & 0xff);
    }
    http_.send(frame + std::string(4, '\0') + bytes);  // a mask of zeros
  }

 private:
  HttpClient http_;
  int status_ = 0;
};

}  // namespace sinew::monitor::test
