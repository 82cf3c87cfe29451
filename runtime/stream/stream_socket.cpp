#include "runtime/stream/stream_socket.h"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <sys/socket.h>
#include <unistd.h>

namespace cairn::stream {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using ErrorCodeOf = boost::system::error_code;

constexpr std::size_t kMostBytes = 4096;  // of a message that a viewer sends
constexpr std::size_t kMostWaiting = 1024;
constexpr std::chrono::seconds kSilence{30};

}  // namespace

struct StreamSocket::State {
  asio::io_context io{1};
  asio::executor_work_guard<asio::io_context::executor_type> keeps_running{io.get_executor()};
  websocket::stream<beast::tcp_stream> socket{io};
  // Of the network's thread.
  beast::flat_buffer incoming;
  std::deque<std::string> outgoing;
  // Of both threads.
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::string> received;
  bool ended = false;
  std::thread network;

  void read() {
    socket.async_read(incoming, [this](ErrorCodeOf error, std::size_t) {
      if (error) return end();
      {
        const std::lock_guard lock(mutex);
        received.push_back(beast::buffers_to_string(incoming.data()));
        incoming.clear();
        if (received.size() > kMostWaiting) error = asio::error::no_buffer_space;
      }
      changed.notify_one();
      if (error) return end();
      read();
    });
  }

  void write() {
    socket.async_write(asio::buffer(outgoing.front()), [this](ErrorCodeOf error, std::size_t) {
      if (error) return end();
      outgoing.pop_front();
      if (!outgoing.empty()) write();
    });
  }

  void end() {
    {
      const std::lock_guard lock(mutex);
      ended = true;
    }
    changed.notify_one();
  }
};

StreamSocket::StreamSocket(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<StreamSocket>> StreamSocket::accept(int descriptor, const std::string& key) {
  sockaddr_storage address{};
  socklen_t length = sizeof(address);
  auto state = std::make_unique<State>();
  ErrorCodeOf error;
  if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    return failed("viewer: expected a connected socket, found none");
  }
  const tcp protocol = address.ss_family == AF_INET6 ? tcp::v6() : tcp::v4();
  beast::get_lowest_layer(state->socket).socket().assign(protocol, descriptor, error);
  if (error) return failed("viewer: " + error.message());

  beast::http::request<beast::http::empty_body> request(beast::http::verb::get, "/", 11);
  request.set(beast::http::field::host, "cairn");
  request.set(beast::http::field::connection, "Upgrade");
  request.set(beast::http::field::upgrade, "websocket");
  request.set(beast::http::field::sec_websocket_version, "13");
  request.set(beast::http::field::sec_websocket_key, key);
  state->socket.read_message_max(kMostBytes);
  state->socket.set_option(websocket::stream_base::timeout{kSilence, kSilence, true});
  state->socket.accept(request, error);
  if (error) return failed("viewer: " + error.message());
  state->socket.binary(true);

  State* shared = state.get();
  shared->read();
  shared->network = std::thread([shared] { shared->io.run(); });
  return std::unique_ptr<StreamSocket>(new StreamSocket(std::move(state)));
}

StreamSocket::~StreamSocket() {
  state_->io.stop();
  state_->network.join();
}

std::optional<std::vector<std::string>> StreamSocket::receive(std::chrono::milliseconds patience) {
  std::unique_lock lock(state_->mutex);
  state_->changed.wait_for(lock, patience, [this] { return state_->ended || !state_->received.empty(); });
  if (state_->ended) return std::nullopt;
  return std::exchange(state_->received, {});
}

void StreamSocket::send(std::string message) {
  asio::post(state_->io, [state = state_.get(), text = std::move(message)]() mutable {
    state->outgoing.push_back(std::move(text));
    if (state->outgoing.size() == 1) state->write();
  });
}

void StreamSocket::close(const std::string& reason) {
  asio::post(state_->io, [state = state_.get(), reason] {
    const websocket::close_reason why(websocket::close_code::policy_error, reason.substr(0, 123));
    state->socket.async_close(why, [state](ErrorCodeOf) { state->end(); });
  });
  while (receive(std::chrono::milliseconds(100))) {
  }
}

}  // namespace cairn::stream
