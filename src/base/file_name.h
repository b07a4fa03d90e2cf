// Names of files in source positions: one word each, so that a million parameters that remember where they were said
// do not carry a string or a count of references. Names are kept until the process ends; there are as many as files
// were read. Thread-safe. It says nothing about whether the file exists.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace kinora {

class FileName {
 public:
  FileName() = default;  // no file
  explicit FileName(std::string_view name);
  explicit operator bool() const { return id_ != 0; }
  const std::string& operator*() const;  // of one that is given; lives as long as the process
  bool operator==(const FileName&) const = default;

 private:
  uint32_t id_ = 0;  // from 1, in order of first use
};

}  // namespace kinora
