// Reads a text as RIB and hands back the worlds and the messages. Used by the tests of this folder only.
#pragma once
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "rib/reader.h"

namespace kinora::rib {

struct Read {
  std::vector<scene::Scene> worlds;
  std::vector<Message> messages;
  bool ok = false;
  uint64_t count(std::string_view code) const {
    uint64_t n = 0;
    for (const Message& m : messages) n += m.code == code;
    return n;
  }
  const Message* find(std::string_view code) const {
    for (const Message& m : messages)
      if (m.code == code) return &m;
    return nullptr;
  }
  const scene::Scene& world() const {
    static const scene::Scene kNone;
    return worlds.empty() ? kNone : worlds.back();
  }
  const scene::Primitive& primitive(size_t i = 0) const {
    static const scene::Primitive kNone;
    return i < world().primitives.size() ? *world().primitives[i] : kNone;
  }
  std::string all() const {
    std::string s;
    for (const Message& m : messages) s += m.str() + "\n";
    return s;
  }
};

inline void expectClean(const Read& r) { EXPECT_TRUE(r.messages.empty()) << r.all(); }

inline Read readRib(const std::vector<std::string>& texts, ReadOptions options = {}) {
  Read out;
  Diagnostics messages([](const std::string&, Severity) {});
  RibReader reader(messages, std::move(options), [&](scene::Scene&& s) { out.worlds.push_back(std::move(s)); });
  out.ok = true;
  int n = 0;
  for (const std::string& t : texts)
    out.ok &= reader.readString(texts.size() == 1 ? "t.rib" : "t" + std::to_string(++n) + ".rib", t);
  reader.finish();
  out.messages = messages.messages();
  return out;
}
inline Read readRib(const std::string& text, ReadOptions options = {}) {
  return readRib(std::vector<std::string>{text}, std::move(options));
}
// The text inside a world; its first line is line 2.
inline Read readWorld(const std::string& text, ReadOptions options = {}) {
  return readRib("WorldBegin\n" + text + "\nWorldEnd\n", std::move(options));
}

// One message of this code, an error or warning, at this line of t.rib.
inline void expectMessage(const Read& r, std::string_view code, uint32_t line) {
  const Message* m = r.find(code);
  ASSERT_TRUE(m) << "no " << code << " among:\n" << r.all();
  EXPECT_EQ(m->pos.line, line) << m->str();
  ASSERT_TRUE(bool(m->pos.file)) << m->str();
  EXPECT_EQ(*m->pos.file, "t.rib");
  EXPECT_FALSE(m->what.empty());
  EXPECT_FALSE(m->done.empty()) << m->str();
  EXPECT_EQ(r.count(code), 1u) << r.all();
}

}  // namespace kinora::rib
