// Draws a pack for one viewer of `cairn serve`, which starts it with the viewer's connection as a descriptor.
#include <csignal>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "runtime/gl/headless_context.h"
#include "runtime/stream/stream_session.h"
#include "runtime/stream/stream_socket.h"

namespace {

struct StreamOptions {
  cairn::viewer::Options view;
  int socket = 0;
  std::string key;
};

cairn::Status stream_pack(const StreamOptions& options) {
  auto socket = cairn::stream::StreamSocket::accept(options.socket, options.key);
  if (!socket) return socket.error();
  const auto refuse = [&](const cairn::Error& error) {
    (*socket)->close(error.message);
    return error;
  };
  const auto size = cairn::viewer::parse_size(options.view.size);
  if (!size) return refuse(size.error());
  auto context = cairn::gl::HeadlessContext::create();
  if (!context) return refuse(context.error());
  auto scene = cairn::viewer::Scene::open(options.view);
  if (!scene) return refuse(scene.error());
  const auto look = cairn::viewer::look_of(options.view, scene->pack());
  if (!look) return refuse(look.error());
  const auto view = cairn::viewer::view_of(options.view, scene->pack(), *size);
  if (!view) return refuse(view.error());
  return cairn::stream::StreamSession(options.view, std::move(*scene), *look, *view).run(**socket);
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  StreamOptions options;
  options.view.size = "640x360";
  options.view.samples = 1;  // a software driver draws four samples in four times the time
  CLI::App app("Draws a pack for one viewer of cairn serve.", "cairn-stream");
  app.add_option("pack", options.view.pack, "the pack")->required();
  app.add_option("socket", options.socket, "the descriptor of the viewer's connection")->required();
  app.add_option("key", options.key, "the request's Sec-WebSocket-Key")->required();
  app.add_option("cache", options.view.cache_mib, "MiB of tiles in memory")->required();
  CLI11_PARSE(app, argc, argv);
  const cairn::Status done = stream_pack(options);
  if (done) return 0;
  std::cerr << "cairn-stream: " << done.error().message << '\n';
  return static_cast<int>(done.error().code);
}
