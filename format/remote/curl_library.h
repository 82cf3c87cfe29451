#pragma once

#include <curl/curl.h>

#include "cairn/status.h"

namespace cairn {

/// The functions of libcurl that are used. They are looked up when the first address is opened.
struct CurlLibrary {
  decltype(&curl_global_init) global_init = nullptr;
  decltype(&curl_easy_init) easy_init = nullptr;
  decltype(&curl_easy_setopt) easy_setopt = nullptr;
  decltype(&curl_easy_perform) easy_perform = nullptr;
  decltype(&curl_easy_getinfo) easy_getinfo = nullptr;
  decltype(&curl_easy_strerror) easy_strerror = nullptr;
  decltype(&curl_easy_cleanup) easy_cleanup = nullptr;
};

/// Returns the loaded library. The error is failed if it is not installed. Any thread.
Result<const CurlLibrary*> curl_library();

}  // namespace cairn
