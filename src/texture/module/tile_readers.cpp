#include "texture/module/tile_readers.h"

#include <algorithm>
#include <system_error>

#include "simd/dispatch.h"

namespace kinora::texture {

TileReaders::~TileReaders() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  for (std::thread& t : threads_) t.join();
}

void TileReaders::readOne(TileRead& read, OIIO::ImageCache::Perthread* thread, std::string& why) {
  OIIO::ImageCache& cache = maker_.cache();
  read.tile = cache.get_tile(read.file, thread, 0, read.level, read.x, read.y, 0);
  // the library keeps what it says for the thread that it said it to
  if (!read.tile && why.empty()) why = cache.geterror();
}

TileReaders::Job TileReaders::take(Batch& batch) {
  Job job{batch.next, batch.next};
  if (job.end < batch.count) ++job.end;
  while (job.end < batch.count && batch.reads[job.end].isWithPrevious) ++job.end;
  batch.next = job.end;
  return job;
}

bool TileReaders::workOn(Batch& batch, OIIO::ImageCache::Perthread* thread, std::unique_lock<std::mutex>& lock) {
  const Job job = take(batch);
  if (job.begin == job.end) return false;
  ++batch.helpers;
  lock.unlock();
  std::string why;
  std::exception_ptr failed;
  try {
    for (uint32_t i = job.begin; i < job.end; ++i) readOne(batch.reads[i], thread, why);
  } catch (...) {  // goes on in the thread that asked, once nobody is at its batch any more
    failed = std::current_exception();
  }
  lock.lock();
  if (batch.why.empty()) batch.why = std::move(why);
  if (failed) {
    batch.failed = failed;
    batch.next = batch.count;
  }
  if (--batch.helpers == 0) done_.notify_all();
  return true;
}

void TileReaders::read(TileRead* reads, uint32_t count, OIIO::ImageCache::Perthread* thread, std::string& why) {
  const TextureReading::Way now = way();
  uint32_t done = 0;
  // until reads are found to wait, or what is left is one that begins nothing new
  while (done < count && (count - done == 1 || reads[done].isWithPrevious || now == TextureReading::InOrder ||
                          now == TextureReading::OneByOne || (now == TextureReading::Measured && !pace_.isSlow())))
    readOne(reads[done++], thread, why);
  if (done == count) return;
  Batch batch;
  batch.reads = reads + done;
  batch.count = count - done;
  std::unique_lock lock(mutex_);
  try {
    while (threads_.size() < size_t(kThreads)) threads_.emplace_back([this] { help(); });
  } catch (const std::system_error&) {  // as many as the system gives; this thread reads in any case
  }
  open_.push_back(&batch);
  wake_.notify_all();
  while (workOn(batch, thread, lock)) {
  }
  std::erase(open_, &batch);
  done_.wait(lock, [&] { return batch.helpers == 0; });
  if (why.empty()) why = std::move(batch.why);
  if (batch.failed) std::rethrow_exception(batch.failed);
}

void TileReaders::help() {
  setThreadFloatMode();  // coarse levels are averages: as lookups by the renderer's threads would make them
  const LevelMaker::Asker asker(maker_);
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return stop_ || !open_.empty(); });
    if (stop_) return;
    Batch& batch = *open_.front();
    open_.pop_front();
    if (batch.next + 1 < batch.count) open_.push_back(&batch);
    workOn(batch, asker.thread(), lock);
  }
}

}  // namespace kinora::texture
