// RIB to RIB, request by request: ASCII or binary, archives in place of the requests that read them. Called by
// `kinora rib`. It keeps every request as it stands, known or not; comments go. It interprets nothing (writer.h
// writes what a scene means), writes no file and does not compress.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/diagnostics.h"

namespace kinora::rib {

struct ConvertOptions {
  bool binary = false;
  bool expand = false;  // ReadArchive and delayed archives: their requests stand in the stream
  std::vector<std::string> archivePath = {};
  std::vector<std::pair<std::string, std::string>> dirmap = {};
};

class Converter {
 public:
  using Sink = std::function<void(std::string_view)>;  // pieces of bounded size, in order
  Converter(Diagnostics& messages, ConvertOptions options, Sink sink);
  ~Converter();
  Converter(const Converter&) = delete;
  // Several files are one stream. False when the file cannot be read or holds no request (a message says why).
  bool file(const std::string& path);
  bool text(const std::string& name, std::string rib);
  void finish();  // hands over what is left; call once

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinora::rib
