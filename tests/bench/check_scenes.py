"""Motion problems (scenes and requests of MotionBenchMaker, packed as YAML in a tar) as plain lines, for bench_check:
'problem NAME', then bodies 'box SX SY SZ X Y Z W X Y Z', 'cylinder LENGTH RADIUS X ...', 'sphere RADIUS X ...' (m, full
sides), then 'start NAME VALUE ...' and 'goal NAME VALUE ...'. Usage: check_scenes.py FILE.tar.bz2 [MOST]"""
import sys
import tarfile

import yaml

LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def pose(p):
    x, y, z, w = p["orientation"]
    return [*p["position"], w, x, y, z]


def write(name, scene, request):
    print("problem", name)
    for item in scene["world"]["collision_objects"]:
        for shape, at in zip(item.get("primitives", []), item.get("primitive_poses", [])):
            print(shape["type"], *shape["dimensions"], *pose(at))
    start = request["start_state"]["joint_state"]
    print("start", *(f"{n} {v}" for n, v in zip(start["name"], start["position"])))
    goal = request["goal_constraints"][0]["joint_constraints"]
    print("goal", *(f"{j['joint_name']} {j['position']}" for j in goal))


def main():
    most = int(sys.argv[2]) if len(sys.argv) > 2 else 1 << 30
    with tarfile.open(sys.argv[1]) as tar:
        names = sorted(m.name for m in tar.getmembers() if "/scene" in m.name and m.name.endswith(".yaml"))
        step = max(1, len(names) // most)
        for name in names[::step][:most]:
            scene = yaml.load(tar.extractfile(name), LOADER)
            request = yaml.load(tar.extractfile(name.replace("/scene", "/request")), LOADER)
            write(name.removesuffix(".yaml"), scene, request)


main()
