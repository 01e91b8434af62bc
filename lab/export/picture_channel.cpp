#include "lab/export/picture_channel.h"

#include <algorithm>

#include "cx/base/file.h"

namespace cxlab::lab {

Expected<PictureChannel> PictureChannel::create(RosBag& bag, const Run& run, const PictureChoice& choice) {
  auto shown = ShownRun::load(run);
  if (!shown) return shown.error();
  PictureChannel out(bag, *std::move(shown));
  auto view = out.shown_.view(choice.width, choice.height);
  if (!view) return view.error();
  out.view_ = *std::move(view);
  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  out.scratch_ = *std::move(scratch);
  out.every_ = choice.every;
  out.camera_ = choice.camera.empty() ? out.view_->cameras().front() : choice.camera;
  return out;
}

Status PictureChannel::see(const Scene& scene) {
  if (scene.t < next_) return {};
  next_ = scene.t + every_;
  if (Status s = shown_.advance_to(scene.t); !s) return s;
  view_->set_time(scene.t);
  const auto picture = view_->draw(camera_);
  if (!picture) return picture.error();
  const std::filesystem::path file = scratch_->path() / "picture.png";
  if (Status s = sim::write_png(**picture, file); !s) return s;
  const auto png = read_file(file);
  if (!png) return png.error();
  const bus::MessageType& type = bag_.own("sensor_msgs/msg/CompressedImage");
  bag_.put("/cxlab/camera/" + topic_part(camera_), scene.t,
           {type.name(), [&] { return bus::ros2msg_schema(type); },
            [&](bus::CdrWriter& out) {
              write_stamp(out, scene.t);
              out.text(camera_).text("png").size(png->size()).bytes(*png);
            }});
  return {};
}

}  // namespace cxlab::lab
