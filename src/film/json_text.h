// Text in JSON, where it is written into files: JSON is Unicode, and names of files and channels need not be. Used by
// what shards hold. Reading throws on what is neither.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace kinora::film {

// A string, or where it is not Unicode a list of its bytes.
inline nlohmann::json jsonOfText(const std::string& text) {
  nlohmann::json plain = text;
  try {
    (void)plain.dump();
    return plain;
  } catch (const nlohmann::json::exception&) {
    nlohmann::json bytes = nlohmann::json::array();
    for (const char c : text) bytes.push_back(int(static_cast<unsigned char>(c)));
    return bytes;
  }
}

inline std::string textOfJson(const nlohmann::json& j) {
  if (j.is_string()) return j.get<std::string>();
  if (!j.is_array()) throw std::runtime_error("a text is missing");
  std::string text;
  for (const nlohmann::json& byte : j) text += char(byte.get<int>());
  return text;
}

}  // namespace kinora::film
