#include "rib/reader.h"

#include "rib/interpreter.h"

namespace kinora::rib {

RibReader::RibReader(Diagnostics& messages, ReadOptions options, OnWorld onWorld)
    : interpreter_(std::make_unique<Interpreter>(messages, std::move(options), std::move(onWorld))) {}
RibReader::~RibReader() = default;
bool RibReader::readFile(const std::string& path) { return interpreter_->readFile(path); }
bool RibReader::readString(const std::string& name, std::string text) {
  return interpreter_->readText(name, std::move(text));
}
void RibReader::finish() { interpreter_->finish(); }
uint64_t RibReader::bytesRead() const { return interpreter_->bytesRead(); }
size_t RibReader::worlds() const { return interpreter_->worlds(); }
std::shared_ptr<const scene::ProceduralSources> RibReader::procedurals() const { return interpreter_->procedurals(); }

}  // namespace kinora::rib
