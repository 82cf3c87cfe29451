#include "format/remote/http_client.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cstring>
#include <string_view>
#include <thread>
#include <utility>

namespace cairn {
namespace {

constexpr std::chrono::milliseconds kFirstPause{100};
constexpr std::chrono::milliseconds kLongestPause{3000};
constexpr long kMostRedirects = 5;
constexpr long kOk = 200;
constexpr long kPartialContent = 206;
constexpr long kRangeNotSatisfiable = 416;
constexpr long kTooManyRequests = 429;
constexpr long kServerErrors = 500;

/// The value of a header's line, if the line is of that header.
std::optional<std::string> value_of(std::string_view line, std::string_view name) {
  if (line.size() <= name.size() || line[name.size()] != ':') return std::nullopt;
  const bool is_named = std::equal(name.begin(), name.end(), line.begin(), [](char a, char b) {
    return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
  });
  if (!is_named) return std::nullopt;
  line.remove_prefix(name.size() + 1);
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  return std::string(line);
}

struct ContentRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t whole = 0;
};

/// "bytes 0-99/1234" (RFC 9110, section 14.4).
std::optional<ContentRange> parse_content_range(std::string_view text) {
  constexpr std::string_view kUnit = "bytes ";
  if (!text.starts_with(kUnit)) return std::nullopt;
  text.remove_prefix(kUnit.size());
  ContentRange range;
  const char* at = text.data();
  const char* end = at + text.size();
  const auto number = [&](std::uint64_t& value, char after) {
    const auto [next, error] = std::from_chars(at, end, value);
    const bool ends = after == '\0' ? next == end : next != end && *next == after;
    at = ends && next != end ? next + 1 : next;
    return error == std::errc() && ends;
  };
  if (!number(range.first, '-') || !number(range.last, '/') || !number(range.whole, '\0'))
    return std::nullopt;
  return range;
}

}  // namespace

/// A connection, and what came of the request that it is at.
struct HttpClient::Transfer {
  explicit Transfer(const CurlLibrary& library) : curl(library), handle(library.easy_init()) {}
  ~Transfer() { curl.easy_cleanup(handle); }
  Transfer(const Transfer&) = delete;
  Transfer& operator=(const Transfer&) = delete;

  void start(std::uint64_t bytes) {
    most = bytes;
    body.clear();
    content_range.clear();
    content_encoding.clear();
    etag.clear();
  }

  // Returning another number than it was given ends the transfer.
  static std::size_t take_body(char* data, std::size_t, std::size_t count, void* self) {
    auto& transfer = *static_cast<Transfer*>(self);
    if (count > transfer.most - transfer.body.size()) return 0;
    const auto* bytes = reinterpret_cast<const std::byte*>(data);
    transfer.body.insert(transfer.body.end(), bytes, bytes + count);
    return count;
  }
  static std::size_t take_header(char* data, std::size_t, std::size_t count, void* self) {
    auto& transfer = *static_cast<Transfer*>(self);
    const std::string_view line(data, count);
    if (line.starts_with("HTTP/")) transfer.start(transfer.most);  // of another answer, after a redirection
    if (const auto value = value_of(line, "content-range")) transfer.content_range = *value;
    if (const auto value = value_of(line, "content-encoding")) transfer.content_encoding = *value;
    if (const auto value = value_of(line, "etag")) transfer.etag = *value;
    return count;
  }

  const CurlLibrary& curl;
  CURL* handle;
  std::uint64_t most = 0;
  std::vector<std::byte> body;
  std::string content_range;
  std::string content_encoding;
  std::string etag;
};

struct HttpClient::Attempt {
  Result<RangeAnswer> answer;
  bool may_succeed_again = false;
};

HttpClient::HttpClient(const CurlLibrary& curl, std::string address, const RemoteOptions& options)
    : curl_(curl), address_(std::move(address)), options_(options) {}
HttpClient::~HttpClient() = default;

std::unique_ptr<HttpClient::Transfer> HttpClient::borrow() const {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      auto transfer = std::move(idle_.back());
      idle_.pop_back();
      return transfer;
    }
  }
  auto transfer = std::make_unique<Transfer>(curl_);
  CURL* handle = transfer->handle;
  if (handle == nullptr) return transfer;
  const auto milliseconds = static_cast<long>(options_.timeout_s * 1000);
  curl_.easy_setopt(handle, CURLOPT_URL, address_.c_str());
  curl_.easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_.easy_setopt(handle, CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
  curl_.easy_setopt(handle, CURLOPT_FOLLOWLOCATION, 1L);
  curl_.easy_setopt(handle, CURLOPT_MAXREDIRS, kMostRedirects);
  curl_.easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
  curl_.easy_setopt(handle, CURLOPT_TIMEOUT_MS, milliseconds);
  curl_.easy_setopt(handle, CURLOPT_USERAGENT, "cairn/" CAIRN_VERSION);
  curl_.easy_setopt(handle, CURLOPT_WRITEFUNCTION, &Transfer::take_body);
  curl_.easy_setopt(handle, CURLOPT_WRITEDATA, transfer.get());
  curl_.easy_setopt(handle, CURLOPT_HEADERFUNCTION, &Transfer::take_header);
  curl_.easy_setopt(handle, CURLOPT_HEADERDATA, transfer.get());
  return transfer;
}

void HttpClient::give_back(std::unique_ptr<Transfer> transfer) const {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(transfer));
}

namespace {

/// What is wrong with an answer that is whole; nothing where it is the range.
std::optional<Error> refusal(long status, const std::string& encoding,
                             const std::optional<ContentRange>& sent, const std::string& range) {
  if (status == kOk)
    return failed("expected a server that sends ranges of bytes, found one that sends whole files");
  if (status == kRangeNotSatisfiable)
    return bad_data("expected bytes " + range + " in it, found a shorter file");
  if (status != kPartialContent)
    return failed("expected bytes " + range + ", found HTTP status " + std::to_string(status));
  if (!encoding.empty() && encoding != "identity")
    return failed("expected bytes as the file has them, found them packed by " + encoding + " on the way");
  if (!sent) return failed("expected a Content-Range for bytes " + range + ", found none");
  return std::nullopt;
}

}  // namespace

HttpClient::Attempt HttpClient::attempt(ByteRange range, bool may_be_short) const {
  auto transfer = borrow();
  if (transfer->handle == nullptr)
    return {failed("expected memory for a connection, found too little"), false};
  const std::string asked =
      std::to_string(range.offset) + "-" + std::to_string(range.offset + range.bytes - 1);
  transfer->start(range.bytes);
  curl_.easy_setopt(transfer->handle, CURLOPT_RANGE, asked.c_str());
  const CURLcode code = curl_.easy_perform(transfer->handle);
  long status = 0;
  curl_.easy_getinfo(transfer->handle, CURLINFO_RESPONSE_CODE, &status);
  const auto sent = parse_content_range(transfer->content_range);
  const auto refused = status == 0 ? std::nullopt : refusal(status, transfer->content_encoding, sent, asked);
  Attempt result{failed(""), false};
  if (refused) {
    result = {*refused, status == kTooManyRequests || status >= kServerErrors};
  } else if (code != CURLE_OK) {
    result = {failed("expected bytes " + asked + ", found: " + curl_.easy_strerror(code)), true};
  } else {
    const std::uint64_t last = sent->last;
    const bool ends_early = may_be_short && last + 1 == sent->whole;
    const bool is_asked =
        sent->first == range.offset && last < sent->whole && last >= sent->first &&
        (last == range.offset + range.bytes - 1 || (ends_early && last < range.offset + range.bytes));
    if (!is_asked) {
      result = {failed("expected bytes " + asked + ", found bytes " + transfer->content_range), false};
    } else if (transfer->body.size() != last - sent->first + 1) {
      result = {failed("expected " + std::to_string(last - sent->first + 1) + " bytes, found " +
                       std::to_string(transfer->body.size())),
                true};
    } else {
      result = {RangeAnswer{std::move(transfer->body), sent->whole, transfer->etag}, false};
    }
  }
  give_back(std::move(transfer));
  return result;
}

Result<RangeAnswer> HttpClient::get(ByteRange range, bool may_be_short) const {
  auto pause = kFirstPause;
  for (int tries = 1;; ++tries) {
    Attempt latest = attempt(range, may_be_short);
    if (latest.answer || !latest.may_succeed_again) return std::move(latest.answer);
    if (tries >= options_.attempts) {
      const Error& error = latest.answer.error();
      return Error{error.code, error.message + ", at " + std::to_string(tries) + " attempts"};
    }
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, kLongestPause);
  }
}

}  // namespace cairn
