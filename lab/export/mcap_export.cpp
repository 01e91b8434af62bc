#include "lab/export/mcap_export.h"

#include "cx/base/file.h"
#include "cx/journal/file_store.h"
#include "lab/versions.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

/// cxlab's own definitions.
Expected<bus::Registry> own_types() {
  bus::Registry out;
  if (Status s = out.add_packages_in(find_share().interfaces); !s) return s.error();
  return out;
}

/// The types of a run: those of its own copies first, then those of cxlab.
Expected<bus::Registry> types_of(const Run& run, const fs::path& folder) {
  auto out = own_types();
  if (!out) return out;
  const auto files = StoredFiles::open(run.folder);
  if (!files) return files.error();
  constexpr std::string_view kBelow = "interfaces/";
  for (const std::string& name : files->names()) {
    if (!name.starts_with(kBelow)) continue;
    const auto text = files->read(name);
    if (!text) return text.error();
    const fs::path file = folder / name;
    std::error_code failure;
    fs::create_directories(file.parent_path(), failure);
    if (Status s = write_file(file, *text); !s) return s.error();
  }
  if (is_folder(folder / kBelow))
    if (Status s = out->add_packages_in(folder / kBelow); !s) return s.error();
  return out;
}

}  // namespace

Expected<std::unique_ptr<McapExport>> McapExport::create(const Run& run, const Stretch& stretch,
                                                         const PictureChoice& pictures, const fs::path& file) {
  auto own = own_types();
  if (!own) return own.error();
  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  auto types = types_of(run, (*scratch)->path());
  if (!types) return types.error();
  auto writer = mcap::Writer::create(file, "ros2", std::string("cxlab ") + cxlab_version());
  if (!writer) return writer.error();
  writer->metadata("cxlab", {{"scenario", fs::path(run.manifest.scenario).filename().string()},
                             {"seed", std::to_string(run.manifest.seed)},
                             {"tier", run.manifest.tier},
                             {"status", run.status},
                             {"version", cxlab_version()}});

  std::unique_ptr<McapExport> out(new McapExport(RosBag(*std::move(writer), *std::move(own))));
  out->definitions_ = *std::move(scratch);
  out->bus_ = std::make_unique<BusChannels>(out->bag_, *std::move(types), stretch);
  if (has_scenes(run)) {
    auto scene = SceneChannels::create(out->bag_, run, stretch);
    if (!scene) return scene.error();
    out->scene_ = std::make_unique<SceneChannels>(*std::move(scene));
  }
  auto story = StoryChannels::create(out->bag_, run, stretch);
  if (!story) return story.error();
  out->story_ = std::make_unique<StoryChannels>(*std::move(story));
  if (pictures.every > SimTime{}) {
    auto channel = PictureChannel::create(out->bag_, run, pictures);
    if (!channel) return channel.error();
    out->pictures_ = std::make_unique<PictureChannel>(*std::move(channel));
  }
  return out;
}

std::vector<PassListener*> McapExport::listeners() {
  std::vector<PassListener*> out{bus_.get(), story_.get()};
  if (scene_) out.push_back(scene_.get());
  if (pictures_) out.push_back(pictures_.get());
  return out;
}

Status McapExport::close() {
  story_->finish();
  return bag_.file().close();
}

}  // namespace cxlab::lab
