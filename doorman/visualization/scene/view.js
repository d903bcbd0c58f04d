// Shows the frames of a flight, from the page itself or as they arrive; one function draws the moment that is asked for.
"use strict";

const THREE = MeshCat.THREE;
const scene = flight.scene;
const frames = [];
const viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
for (const command of scene.commands) viewer.handle_command(command);
const back = Math.min(1.8, Math.max(1, innerHeight / innerWidth));  // a tall screen sees less to the sides: farther back
viewer.camera.position.set(...scene.camera.eye.map((one, axis) => scene.camera.target[axis] + back * (one - scene.camera.target[axis])));
viewer.controls.target.set(...scene.camera.target);

const element = (id) => document.getElementById(id);
const node = (path) => viewer.scene_tree.find(path.split("/")).object;
const world = node("scene");
const nodes = scene.nodes.map(node);
const rotors = scene.rotors.map(([path, direction]) => [node(path), direction]);

// ---------------------------------------------------------------- light, shadows, walls that would hide the vehicle

const meshes = [];
world.traverse((object) => { if (object.isMesh) meshes.push(object); });
const surfaceMaterials = scene.surfaces.map(({node: path}) => node(path + "/<object>").material);
const walls = [];  // of the door what its URDF draws transparent
node("scene/door").traverse((object) => {
    if (object.isMesh && object.material.transparent && !surfaceMaterials.includes(object.material)) walls.push(object);
});
for (const wall of walls) wall.material.opacity = 1;

const REACH = 4.0;  // of the shadows around what the camera looks at [m]
viewer.renderer.shadowMap.enabled = true;
viewer.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
const sun = new THREE.DirectionalLight("#ffffff", 0.35);
sun.castShadow = true;
sun.shadow.mapSize.set(2048, 2048);
sun.shadow.bias = -0.0005;
Object.assign(sun.shadow.camera, {left: -REACH, right: REACH, top: REACH, bottom: -REACH, near: 0.1, far: 4 * REACH});
const [middleX, middleZ, middleY] = scene.camera.target;  // the camera's frame has y up
sun.target.position.set(middleX, -middleY, middleZ);
sun.position.copy(sun.target.position).add(new THREE.Vector3(...scene.sun).multiplyScalar(2 * REACH));
world.add(sun, sun.target);
for (const mesh of meshes) mesh.castShadow = mesh.receiveShadow = !mesh.material.transparent;
for (const wall of walls) wall.receiveShadow = true;

const HIDDEN = 0.15, ray = new THREE.Raycaster();
function showVehicleThroughWalls() {
    const eye = viewer.camera.getWorldPosition(new THREE.Vector3());
    const towards = node("scene/vehicle").getWorldPosition(new THREE.Vector3()).sub(eye);
    ray.set(eye, towards.clone().normalize());
    ray.far = towards.length();
    for (const wall of walls) wall.material.opacity = ray.intersectObject(wall, false).length ? HIDDEN : 1;
}

// ---------------------------------------------------------------- colours of clearance

const BLOCKED = new THREE.Color("#D55E00"), TIGHT = new THREE.Color("#E69F00"), FREE = new THREE.Color("#56B4E9");
const ROOMY = 0.3;  // from here on a surface is pale [m]
const surfaces = scene.surfaces.map(({node: path, name}) => ({name, material: node(path + "/<object>").material}));
element("legend").innerHTML = "<table>" + surfaces.map(() => "<tr><td><span class=swatch></span></td><td></td><td></td></tr>").join("") + "</table>";
const cells = [...element("legend").querySelectorAll("tr")].map((row) => row.children);
surfaces.forEach(({name}, i) => { cells[i][1].textContent = name; });

function colorOf(clearance) {
    const color = new THREE.Color();
    if (clearance <= 0) return color.copy(BLOCKED);
    return color.copy(TIGHT).lerp(FREE, Math.min(Math.max(clearance - scene.margin, 0) / (ROOMY - scene.margin), 1));
}

function showClearances(clearances) {
    clearances.forEach((clearance, i) => {
        const {material} = surfaces[i], color = colorOf(clearance);
        material.color.copy(color);
        material.emissive.copy(color).multiplyScalar(0.4);
        material.opacity = 0.1 + 0.3 * (1 - Math.min(Math.max(clearance, 0) / ROOMY, 1));
        material.side = THREE.DoubleSide;
        cells[i][0].firstChild.style.background = "#" + color.getHexString();
        cells[i][2].textContent = clearance.toFixed(2) + " m";
    });
}

function showSurfaces(on) {
    for (const surface of scene.surfaces) node(surface.node).visible = on;
    element("legend").hidden = !on;
    viewer.set_dirty();
}
element("surfaces").onchange = ({target}) => showSurfaces(target.checked);
showSurfaces(false);

// ---------------------------------------------------------------- ribbon, arrow, trace

function meshOf(geometry, color, opacity) {
    const material = new THREE.MeshLambertMaterial(
        {color, opacity, transparent: opacity < 1, side: THREE.DoubleSide, emissive: color, emissiveIntensity: 0.5});
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    return mesh;
}

const LONGEST_RIBBON = 64;
const ribbon = meshOf(new THREE.BufferGeometry(), "#009E73", 0.75);
ribbon.name = "ribbon";
ribbon.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(6 * LONGEST_RIBBON), 3));
ribbon.geometry.setIndex([...Array(LONGEST_RIBBON - 1).keys()].flatMap((k) => [0, 1, 2, 2, 1, 3].map((i) => 2 * k + i)));
world.add(ribbon);

function showRibbon(rows) {
    ribbon.visible = rows !== null;
    if (rows === null) return;
    const positions = ribbon.geometry.attributes.position;
    positions.array.set(rows.flat());
    positions.needsUpdate = true;
    ribbon.geometry.setDrawRange(0, 6 * (rows.length - 1));
    ribbon.geometry.computeVertexNormals();
}

const METRES_PER_NEWTON = 0.06, HEAD = 0.07, LEAST_FORCE = 0.05;
const arrow = new THREE.Group(), shaft = meshOf(new THREE.CylinderGeometry(0.011, 0.011, 1, 16), "#CC79A7", 0.95);
const head = meshOf(new THREE.ConeGeometry(0.028, HEAD, 20), "#CC79A7", 0.95);
arrow.name = "force";
arrow.add(shaft, head);
for (const part of arrow.children) {  // seen through the leaf that it points into
    part.material.depthTest = false;
    part.renderOrder = 1;
}
world.add(arrow);
const UP = new THREE.Vector3(0, 1, 0);  // along which three's cylinders stand

function showForce(tip, force) {
    const vector = new THREE.Vector3(...(force || [0, 0, 0])), size = vector.length();
    arrow.visible = size > LEAST_FORCE;
    if (!arrow.visible) return;
    const length = METRES_PER_NEWTON * size;
    shaft.scale.y = length;
    shaft.position.y = 0.5 * length;
    head.position.y = length + 0.5 * HEAD;
    arrow.position.set(...tip);
    arrow.quaternion.setFromUnitVectors(UP, vector.divideScalar(size));
}

const SPACING = 0.01, MOST_DOTS = 5000;
const trace = new THREE.InstancedMesh(
    new THREE.SphereGeometry(0.006, 8, 6), new THREE.MeshBasicMaterial({color: "#D55E00"}), MOST_DOTS);
trace.name = "trace";
trace.frustumCulled = false;
trace.count = 0;
world.add(trace);
let dots = 0, lastDot = null;

function extendTrace(tip) {
    const point = new THREE.Vector3(...tip);
    const steps = lastDot === null ? 1 : Math.floor(point.distanceTo(lastDot) / SPACING);
    const from = lastDot === null ? point : lastDot.clone();
    for (let k = 1; k <= steps && dots < MOST_DOTS; k++) {
        lastDot = from.clone().lerp(point, k / steps);
        trace.setMatrixAt(dots++, new THREE.Matrix4().makeTranslation(lastDot.x, lastDot.y, lastDot.z));
        trace.instanceMatrix.needsUpdate = true;
    }
    return dots;
}

// ---------------------------------------------------------------- one moment

function add(frame) {
    frame.dots = extendTrace(frame.tip);
    frames.push(frame);
    slider.min = frames[0].time;
    slider.max = frame.time;
}

function frameAt(time) {  // the last one that is not after it
    let low = 0, high = frames.length - 1;
    while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (frames[middle].time <= time + 1e-6) low = middle; else high = middle - 1;
    }
    return low;
}

function showPoses(now, next, share) {
    const to = new THREE.Quaternion();
    nodes.forEach((object, i) => {
        const a = now.poses[i], b = next.poses[i];
        object.position.set(...[0, 1, 2].map((k) => a[k] + share * (b[k] - a[k])));
        object.quaternion.set(...a.slice(3)).slerp(to.set(...b.slice(3)), share);
    });
}

function show(time) {
    const index = frameAt(time), now = frames[index], next = frames[Math.min(index + 1, frames.length - 1)];
    const share = next.time > now.time ? Math.min(Math.max((time - now.time) / (next.time - now.time), 0), 1) : 0;
    showPoses(now, next, share);
    showClearances(now.clearances);
    showRibbon(now.ribbon);
    showForce(now.tip, now.force);
    showVehicleThroughWalls();
    trace.count = now.dots;
    for (const [rotor, direction] of rotors) rotor.rotation.z = direction * scene.rotor_rate * time;
    const force = now.force === null ? "" : `, tip force ${Math.hypot(...now.force).toFixed(1)} N`;
    element("values").textContent = `${time.toFixed(2)} s, door at ${now.door_angle.toFixed(1)}° (goal ${scene.goal.toFixed(1)}°)${force}`;
    element("phase").textContent = now.phase;
    element("reason").textContent = now.reason;
    viewer.set_dirty();
}

// ---------------------------------------------------------------- time

const slider = element("moment"), toggle = element("toggle"), speed = element("speed"), follow = element("follow");
const REST = 1.5;  // at the end, before it starts again [s]
let time = 0, playing = true, following = Boolean(flight.live), rested = 0, shown = null;

function setPlaying(on) {
    playing = on;
    toggle.textContent = on ? "Pause" : "Play";
}
function seek(to) {
    following = false;
    setPlaying(false);
    time = to;
}
toggle.onclick = () => { following = false; setPlaying(!playing); };
slider.oninput = () => seek(Number(slider.value));
follow.onclick = () => { following = true; setPlaying(true); };
document.addEventListener("keydown", (event) => {
    if (event.target === speed) return;
    if (event.key === " ") { toggle.click(); event.preventDefault(); }
});

let before = performance.now();
function tick(now) {
    requestAnimationFrame(tick);
    const passed = (now - before) / 1000;
    before = now;
    if (!frames.length) return;
    const first = frames[0].time, last = frames[frames.length - 1].time;
    if (following) time = last;
    else if (playing) {
        time += passed * Number(speed.value);
        if (time > last) {
            time = last;
            rested += passed;
            if (rested > REST) { time = first; rested = 0; }
        }
    }
    time = Math.min(Math.max(time, first), last);
    if (time === shown) return;
    shown = time;
    if (document.activeElement !== slider || playing) slider.value = time;
    show(time);
}

flight.frames.forEach(add);
if (frames.length) time = frames[0].time;
const asked = location.hash.match(/^#t=([0-9.]+)$/);  // an address may end in #t=<seconds>: stop there
if (asked) { seek(Number(asked[1])); slider.value = time; }

if (flight.live) {
    follow.hidden = false;
    const source = new EventSource(flight.live);
    source.onmessage = (event) => JSON.parse(event.data).forEach(add);
    source.addEventListener("end", () => { source.close(); follow.hidden = true; following = false; setPlaying(false); });
}
requestAnimationFrame(tick);
