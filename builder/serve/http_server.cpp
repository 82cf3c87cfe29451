#include "builder/serve/http_server.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/write.hpp>
#include <sys/resource.h>

namespace cairn {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;
using ErrorCodeOf = boost::system::error_code;

constexpr std::size_t kPieceBytes = 65536;
constexpr std::chrono::seconds kLinger{2};
constexpr int kSpareDescriptors = 64;  // of the program itself

/// What all connections share. `io` runs on one thread, so nothing here needs a lock; handlers and reads of
/// files run in `workers`.
struct Shared {
  Shared(HttpHandler h, const HttpLimits& l) : handler(std::move(h)), limits(l) {}

  // Connections end with `io`, and reach all that is above it.
  HttpHandler handler;
  HttpLimits limits;
  int open = 0;          // connections
  bool waiting = false;  // for one to close
  asio::io_context io{1};
  std::optional<asio::thread_pool> workers;
  tcp::acceptor acceptor{io};

  void accept();
};

/// One connection: reads a request, has it answered, sends the answer, and begins again.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket&& socket, Shared& shared) : shared_(shared), stream_(std::move(socket)) {
    ++shared_.open;
  }

  ~Connection() {
    --shared_.open;
    if (shared_.waiting && !shared_.io.stopped()) {
      shared_.waiting = false;
      shared_.accept();
    }
  }

  void read() {
    parser_.emplace();
    parser_->header_limit(shared_.limits.header_bytes);
    parser_->body_limit(0);
    stream_.expires_after(shared_.limits.request_time);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](ErrorCodeOf error, std::size_t) { self->take(error); });
  }

 private:
  void take(ErrorCodeOf error) {
    if (error) {
      if (error == http::error::header_limit)
        return refuse(431, "request: expected a header of 8 KiB at most");
      if (error == http::error::body_limit) return refuse(413, "request: expected no body");
      // Only what the parser says is the client's fault; all else is a connection that ended.
      if (error.category() == http::make_error_code(http::error::bad_method).category() &&
          error != http::error::end_of_stream && error != http::error::partial_message)
        return refuse(400, "request: expected HTTP/1.1, found " + error.message());
      return;
    }
    const auto& message = parser_->get();
    keep_alive_ = message.keep_alive();
    head_ = message.method() == http::verb::head;
    if (message.method() == http::verb::options) return send({204, {}, {}, {}});
    if (!head_ && message.method() != http::verb::get) {
      HttpAnswer answer = error_answer(405, "method: expected GET, HEAD or OPTIONS");
      answer.fields.emplace_back("Allow", "GET, HEAD, OPTIONS");
      return send(std::move(answer));
    }
    auto request = parse_target(std::string(message.target()));
    if (!request) return send(error_answer(400, "target: expected a path with valid escapes"));
    for (const auto& field : message) {
      std::string name(field.name_string());
      std::transform(name.begin(), name.end(), name.begin(),
                     [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; });
      request->fields[name] = std::string(field.value());
    }
    stream_.expires_never();
    asio::post(*shared_.workers, [self = shared_from_this(), request = std::move(*request)]() mutable {
      Shared& shared = self->shared_;
      HttpAnswer answer = shared.handler(request);
      asio::post(shared.io, [self = std::move(self), answer = std::move(answer)]() mutable {
        self->send(std::move(answer));
      });
    });
  }

  /// Gives the connection to another server, to which a client speaks only after an answer.
  void hand_over(const HttpAnswer& answer) {
    if (buffer_.size() != 0) return refuse(400, "request: expected nothing behind it, found more bytes");
    ErrorCodeOf error;
    const int socket = stream_.release_socket().release(error);
    if (!error) answer.take_socket(socket);
  }

  /// Answers and closes: where a message is malformed, nobody knows where the next one begins.
  void refuse(int status, const std::string& text) {
    keep_alive_ = false;
    send(error_answer(status, text));
  }

  void send(HttpAnswer answer) {
    if (answer.take_socket) return hand_over(answer);
    answer_ = std::move(answer);
    response_ = {};
    response_.version(11);
    response_.result(static_cast<unsigned>(answer_.status));
    for (const auto& [name, value] : answer_.fields) response_.set(name, value);
    response_.set(http::field::access_control_allow_origin, "*");
    response_.set(http::field::access_control_expose_headers,
                  "ETag, Content-Range, Content-Length, Accept-Ranges");
    response_.set("Cross-Origin-Resource-Policy", "cross-origin");
    response_.set("X-Content-Type-Options", "nosniff");
    if (answer_.status == 204) {
      response_.set(http::field::access_control_allow_methods, "GET, HEAD, OPTIONS");
      response_.set(http::field::access_control_allow_headers, "Range, If-Match, If-None-Match, If-Range");
      response_.set(http::field::access_control_max_age, "86400");
    }
    if (answer_.status != 204 && answer_.status != 304)
      response_.content_length(answer_.file ? answer_.file->bytes : answer_.body.size());
    response_.keep_alive(keep_alive_);
    serializer_.emplace(response_);
    sent_ = 0;
    stream_.expires_after(shared_.limits.piece_time);
    http::async_write_header(stream_, *serializer_,
                             [self = shared_from_this()](ErrorCodeOf error, std::size_t) {
                               if (!error) self->send_piece();
                             });
  }

  void send_piece() {
    const std::uint64_t total = answer_.file ? answer_.file->bytes : answer_.body.size();
    if (head_ || answer_.status == 304 || sent_ == total) return finish();
    const auto bytes = static_cast<std::size_t>(std::min<std::uint64_t>(kPieceBytes, total - sent_));
    if (!answer_.file) return write(answer_.body.data() + sent_, bytes);
    piece_.resize(bytes);
    stream_.expires_never();
    asio::post(*shared_.workers, [self = shared_from_this()]() mutable {
      Shared& shared = self->shared_;
      const FilePart& part = *self->answer_.file;
      const bool read =
          part.file->read(part.offset + self->sent_, std::as_writable_bytes(std::span(self->piece_))).ok();
      asio::post(shared.io, [self = std::move(self), read] {
        // A length was sent that can no longer be kept: the client sees an answer that ends early.
        if (read) self->write(self->piece_.data(), self->piece_.size());
      });
    });
  }

  void write(const char* data, std::size_t bytes) {
    stream_.expires_after(shared_.limits.piece_time);
    asio::async_write(stream_, asio::buffer(data, bytes),
                      [self = shared_from_this()](ErrorCodeOf error, std::size_t written) {
                        if (error) return;
                        self->sent_ += written;
                        self->send_piece();
                      });
  }

  void finish() {
    answer_ = {};
    if (keep_alive_) return read();
    ErrorCodeOf ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.expires_after(kLinger);
    linger();
  }

  /// Takes what still comes, for a while: to close a socket with unread bytes would take the answer back.
  void linger() {
    buffer_.clear();
    stream_.async_read_some(buffer_.prepare(kPieceBytes),
                            [self = shared_from_this()](ErrorCodeOf error, std::size_t) {
                              if (!error) self->linger();
                            });
  }

  Shared& shared_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{65536};
  std::optional<http::request_parser<http::empty_body>> parser_;
  http::response<http::empty_body> response_;
  std::optional<http::response_serializer<http::empty_body>> serializer_;
  HttpAnswer answer_;
  std::vector<char> piece_;
  std::uint64_t sent_ = 0;
  bool keep_alive_ = false;
  bool head_ = false;
};

void Shared::accept() {
  if (open >= limits.connections) {
    waiting = true;
    return;
  }
  acceptor.async_accept([this](ErrorCodeOf error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      ErrorCodeOf ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<Connection>(std::move(socket), *this)->read();
    }
    accept();
  });
}

/// Returns how many connections the limit of open files allows, after raising it as far as it may be.
int allowed_connections(int wanted) {
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return wanted;
  const rlim_t needed = static_cast<rlim_t>(wanted + kSpareDescriptors);
  if (files.rlim_cur < needed) {
    files.rlim_cur = std::min(needed, files.rlim_max);
    ::setrlimit(RLIMIT_NOFILE, &files);
    ::getrlimit(RLIMIT_NOFILE, &files);
  }
  return files.rlim_cur >= needed ? wanted
                                  : std::max(1, static_cast<int>(files.rlim_cur) - kSpareDescriptors);
}

}  // namespace

struct HttpServer::State : Shared {
  using Shared::Shared;
};

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
HttpServer::HttpServer(HttpServer&&) noexcept = default;
HttpServer::~HttpServer() = default;

Result<HttpServer> HttpServer::listen(const std::string& address, std::uint16_t port, HttpHandler handler,
                                      const HttpLimits& limits) {
  auto state = std::make_unique<State>(std::move(handler), limits);
  state->limits.connections = allowed_connections(limits.connections);
  ErrorCodeOf error;
  const asio::ip::address where = asio::ip::make_address(address, error);
  if (error) return usage_error("address: expected an IPv4 or IPv6 address, found " + address);
  const tcp::endpoint endpoint(where, port);
  state->acceptor.open(endpoint.protocol(), error);
  if (!error) state->acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) state->acceptor.bind(endpoint, error);
  if (!error) state->acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error)
    return failed(address + ": port " + std::to_string(port) + ": cannot be listened on: " + error.message());
  return HttpServer(std::move(state));
}

std::uint16_t HttpServer::port() const {
  ErrorCodeOf ignored;
  return state_->acceptor.local_endpoint(ignored).port();
}

void HttpServer::run(int threads) {
  state_->workers.emplace(static_cast<std::size_t>(threads));
  state_->accept();
  state_->io.run();
  state_->workers->stop();
  state_->workers->join();
}

void HttpServer::stop() {
  state_->io.stop();
}

}  // namespace cairn
