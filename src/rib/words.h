// Numbers and strings as ASCII RIB has them, appended to a text. Used by the writer and by ri/.
#pragma once
#include <charconv>
#include <string>
#include <string_view>

namespace kinora::rib {

template <class T>
void appendNumber(T v, std::string& text) {
  char buffer[40];
  const auto r = std::to_chars(buffer, buffer + sizeof buffer, v);  // the shortest that reads back to the same bits
  text.append(buffer, r.ptr);
  if (v == 0 && std::string_view(buffer, r.ptr) == "-0") text += '.';  // as an integer it would lose its sign
}

inline void appendString(std::string_view s, std::string& text) {
  text += '"';
  for (const char c : s) {
    if (c == '"' || c == '\\')
      text += '\\', text += c;
    else if (c == '\n')
      text += "\\n";
    else if (static_cast<unsigned char>(c) < 32) {
      const char octal[] = {'\\', char('0' + (c >> 6)), char('0' + ((c >> 3) & 7)), char('0' + (c & 7)), 0};
      text += octal;
    } else
      text += c;
  }
  text += '"';
}

}  // namespace kinora::rib
