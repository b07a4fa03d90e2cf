#include "fuzz/ies_mutator.h"

#include <algorithm>
#include <iterator>

namespace kinora::fuzz {

namespace {

constexpr const char* kNumbers[] = {
    "0",           "-0",      "1",    "-1",  "2",    "3",    "45",    "90",          "180",   "270",     "360",
    "-90",         "361",     "nan",  "inf", "-inf", "1e30", "1e308", "1e39",        "1e-9",  "1e999",   "2147483648",
    "-2147483649", "1048576", "1025", ".",   "+",    "1e",   "0x10",  "99999999999", "1e-45", "89.99999"};
constexpr const char* kWords[] = {"TILT=NONE",
                                  "TILT=INCLUDE",
                                  "TILT=lamp.tlt",
                                  "TILT=",
                                  "TILT=NONE\r\n",
                                  "IESNA:LM-63-1995",
                                  "IESNA91",
                                  "[TEST] 1",
                                  "[MORE]",
                                  "[_OWN]",
                                  "\n",
                                  "\r",
                                  "\t",
                                  ",",
                                  " ",
                                  "\xEF\xBB\xBF"};

}  // namespace

std::string IesMutator::number() {
  switch (below(3)) {
    case 0:
      return kNumbers[below(std::size(kNumbers))];
    case 1:
      return std::to_string(below(361));
    default:
      return std::to_string(below(36000) / 100.0);
  }
}

std::string IesMutator::word() { return kWords[below(std::size(kWords))]; }

std::string IesMutator::profile() {
  std::string s = below(4) ? "IESNA:LM-63-2002\n[TEST] a\n[MANUFAC] b\n" : "";
  if (below(4) == 0)
    s += "TILT=INCLUDE\n1\n3\n0 45 90\n1 .9 .8\n";
  else
    s += "TILT=NONE\n";
  // which angles the type and its symmetries allow
  const uint32_t type = below(4) ? 1 : 2 + below(2);
  static constexpr int kSpans[][2] = {{0, 0}, {0, 90}, {0, 180}, {0, 360}, {90, 270}, {0, 345}};
  const int* span = kSpans[type == 1 ? below(std::size(kSpans)) : below(2)];
  const int from = type != 1 && below(2) ? -span[1] : span[0], to = span[1];
  const uint32_t vertical = 2 + below(5), horizontal = from == to ? 1 : 2 + below(5);
  const int low = type == 1 ? 0 : -90, high = type == 1 ? (below(2) ? 90 : 180) : 90;
  s += "1 1000 " + std::to_string(1 + below(3)) + " " + std::to_string(vertical) + " " + std::to_string(horizontal) +
       " " + std::to_string(type) + " " + std::to_string(1 + below(2)) + " .1 .1 .05\n1 1 60\n";
  for (uint32_t i = 0; i < vertical; ++i)
    s += std::to_string(low + double(high - low) * i / (vertical - 1)) + (below(6) ? " " : "\n");
  s += "\n";
  for (uint32_t i = 0; i < horizontal; ++i)
    s += std::to_string(horizontal == 1 ? from : from + double(to - from) * i / (horizontal - 1)) + " ";
  s += "\n";
  for (uint32_t i = 0; i < vertical * horizontal; ++i)
    s += std::to_string(below(5) ? below(20000) / 10.0 : 0) + (below(9) ? " " : "\n");
  return s + "\n";
}

IesMutator::Tokens IesMutator::tokensOf(const std::string& s) {
  Tokens t;
  const auto isBetween = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == ','; };
  for (size_t i = 0; i < s.size();) {
    size_t end = i + 1;
    while (end < s.size() && isBetween(s[end]) == isBetween(s[i])) ++end;
    t.push_back(s.substr(i, end - i));
    i = end;
  }
  return t;
}

void IesMutator::change(Tokens& t, const Tokens& other) {
  if (t.empty()) return;
  const auto at = [&] { return t.begin() + std::ptrdiff_t(below(t.size())); };
  const uint32_t which = below(10);
  if (which < kRearrangements) return rearrange(which, t, other, 300);
  switch (which) {
    case 4:
      t.insert(at(), " " + number() + " ");
      break;
    case 5:
      t.insert(at(), "\n" + word() + "\n");
      break;
    case 6: {  // cut off
      t.erase(at(), t.end());
      break;
    }
    case 7: {
      std::string& s = *at();
      s[below(s.size())] = char(below(256));
      break;
    }
    default:
      *at() = number();
  }
}

std::string IesMutator::mutate(const std::string& input, const std::string& other, size_t limit) {
  Tokens t = tokensOf(below(6) ? input : profile());
  const Tokens pieces = tokensOf(other);
  for (uint32_t n = 1 + below(4); n > 0; --n) change(t, pieces);
  return textOf(t, limit);
}

}  // namespace kinora::fuzz
