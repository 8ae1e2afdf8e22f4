//! Draws bodies: a row of growth forms, a colony over the years, and a plot from the side and from above.
//!
//! `cargo run --release -p eyot-render --example bodies -- FOLDER [forms|growth|plot|speed] [coarse|fine]`

use eyot_mesh::Point;
use eyot_reef::bodies::{Bodies, Body, BodyPlan, ColonyShape, Detail, Sculptor, Shape};
use eyot_reef::community::{Community, Forcing, Plot, RAYS, Site, Species};
use eyot_render::{Camera, Haze, MeshPart, MeshViewOptions, Picture, mesh_view};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = PathBuf::from(arguments.first().ok_or("give a folder")?);
    std::fs::create_dir_all(&folder)?;
    let detail = if arguments.get(2).is_some_and(|a| a == "coarse") { Detail::default() } else { Detail::fine() };
    match arguments.get(1).map_or("all", String::as_str) {
        "forms" => forms(&folder, detail),
        "growth" => growth(&folder, detail),
        "plot" => plot(&folder, detail),
        "speed" => speed(detail),
        _ => forms(&folder, detail).and_then(|()| growth(&folder, detail)).and_then(|()| plot(&folder, detail)),
    }
}

/// Species of all growth forms: those of the source, and made-up ones.
fn all_forms() -> Community {
    let mut community = Community::default();
    let massive = community.species[0].clone();
    let form = |shape: Shape, height: f32, solid_share: f32, colour: [u8; 3]| Species {
        name: format!("{shape:?}"),
        solid_share,
        body: BodyPlan { shape, height, colours: [colour; 2], ..BodyPlan::default() },
        ..massive.clone()
    };
    community.species.extend([
        form(Shape::Columnar, 1.2, 0.35, [150, 150, 80]),
        form(Shape::Encrusting, 0.1, 0.12, [170, 90, 120]),
        form(Shape::Foliaceous, 1.0, 0.2, [130, 100, 70]),
        form(Shape::Laminar, 0.5, 0.17, [120, 140, 90]),
        form(Shape::FreeLiving, 0.35, 0.3, [190, 130, 80]),
    ]);
    community
}

fn forms(folder: &Path, detail: Detail) -> Result<()> {
    let community = all_forms();
    let sculptor = Sculptor::new(&community, 1, detail)?;
    let mut bodies = Vec::new();
    for (i, s) in community.species.iter().enumerate() {
        let r = s.max_radius.min(0.5);
        for id in 0..2u64 {
            let rays = std::array::from_fn(|k| r * (1.0 + 0.1 * ((k as f32 * 0.7 + id as f32 * 2.0).sin())));
            let start = Instant::now();
            let body = sculptor.body(&ColonyShape {
                id: 10 * i as u64 + id,
                species: i,
                rays: &rays,
                bleaching: 0.0,
                slope: [0.0; 2],
            })?;
            report(&s.name, &body, start);
            bodies.push((body, [1.3 * i as f32, 1.4 * id as f32, 0.0]));
        }
    }
    let middle = 0.65 * (community.species.len() - 1) as f32;
    let camera = Camera::looking([middle, 9.0, 4.2], [middle, 0.6, 0.1], 27.0);
    save(folder, "forms.png", &draw(&bodies, camera, [1800, 700], None))?;
    for (i, s) in community.species.iter().enumerate() {
        let (body, _) = &bodies[2 * i];
        let camera = Camera::looking([0.9, 1.4, 0.75], [0.0, 0.0, 0.18], 40.0);
        let name = format!("{}.png", s.name.replace(' ', "_"));
        save(folder, &name, &draw(&[(body.clone(), [0.0; 3])], camera, [700, 560], None))?;
    }
    Ok(())
}

fn report(name: &str, body: &Body, start: Instant) {
    let (t, q) = (body.solid.topology(), body.solid.quality());
    println!(
        "{name:24} {:7} triangles, voxel {:.4}, {:5.1} ms, slivers {:.4}, closed {}, pieces {}, Euler {}, errors {:.4?}, stretch {:.2?}",
        t.triangles,
        body.voxel_m,
        1e3 * start.elapsed().as_secs_f64(),
        q.slivers,
        t.is_closed_manifold(),
        t.pieces,
        t.euler(),
        body.fit.errors(),
        body.fit.stretch,
    );
}

fn growth(folder: &Path, detail: Detail) -> Result<()> {
    let community = Community::default();
    let sculptor = Sculptor::new(&community, 1, detail)?;
    let mut bodies = Vec::new();
    for species in 0..4usize {
        let mut x = 0.0;
        for step in 1..=6 {
            let r = community.species[species].max_radius.min(0.6) * step as f32 / 6.0;
            let start = Instant::now();
            let colony = ColonyShape { id: 77, species, rays: &[r; RAYS], bleaching: 0.0, slope: [0.0; 2] };
            let body = sculptor.body(&colony)?;
            report(&format!("{} {r:.2} m", community.species[species].name), &body, start);
            x += 1.3 * r;
            bodies.push((body, [x, 1.3 * species as f32, 0.0]));
            x += 1.3 * r;
        }
    }
    let camera = Camera::looking([2.3, 9.5, 4.2], [2.3, 1.8, 0.1], 34.0);
    save(folder, "growth.png", &draw(&bodies, camera, [1500, 1100], None))
}

/// Makes all bodies of a plot of 10 x 10 m again and again.
fn speed(detail: Detail) -> Result<()> {
    let community = Community::default();
    let forcing = Forcing::chumbe(&community, 1)?;
    let mut plot = Plot::new(community, Site::flat(10.0, 10.0), forcing, 1)?;
    plot.month()?;
    for _ in 0..5 {
        let mut bodies = Bodies::new(plot.community(), 1, detail)?;
        let start = Instant::now();
        let made = bodies.update(&plot)?;
        let time = start.elapsed().as_secs_f64();
        let triangles: usize =
            plot.colonies().iter().filter_map(|c| bodies.of(c.id)).map(|b| b.solid.triangles()).sum();
        println!("{made} bodies, {triangles} triangles, {:.1} ms", 1e3 * time);
    }
    Ok(())
}

fn plot(folder: &Path, detail: Detail) -> Result<()> {
    let community = Community::default();
    let forcing = Forcing::chumbe(&community, 1)?;
    let mut plot = Plot::new(community, Site::flat(10.0, 10.0), forcing, 1)?;
    for _ in 0..60 {
        plot.month()?;
    }
    let mut bodies = Bodies::new(plot.community(), 1, detail)?;
    let start = Instant::now();
    let made = bodies.update(&plot)?;
    let time = start.elapsed().as_secs_f64();
    let all: Vec<(Body, Point)> =
        plot.colonies().iter().filter_map(|c| Some((bodies.of(c.id)?.clone(), [c.x - 5.0, c.y - 5.0, 0.0]))).collect();
    let triangles: usize = all.iter().map(|b| b.0.solid.triangles()).sum();
    println!("{made} bodies, {triangles} triangles, {:.1} ms", 1e3 * time);
    let haze = Haze { per_m: [0.16, 0.05, 0.045], veil: [0.02, 0.16, 0.24] };
    let side = Camera::looking([-1.0, 8.2, 2.6], [0.0, 0.0, 0.2], 48.0);
    save(folder, "plot_side.png", &draw(&all, side, [1400, 900], Some(haze)))?;
    let above = Camera::looking([0.0, 0.01, 13.0], [0.0, 0.0, 0.0], 46.0);
    save(folder, "plot_above.png", &draw(&all, above, [1100, 1100], None))
}

/// Bodies on a sandy ground.
fn draw(bodies: &[(Body, Point)], camera: Camera, [width, height]: [usize; 2], haze: Option<Haze>) -> Picture {
    let middle =
        bodies.iter().fold([0.0f32; 2], |m, b| [m[0] + b.1[0], m[1] + b.1[1]]).map(|v| v / bodies.len() as f32);
    let n = 80usize;
    let at = |i: usize| 30.0 * (i as f32 / n as f32 - 0.5);
    let points = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let ground: Vec<Point> = points.map(|(i, j)| [at(i) + middle[0], 0.0, at(j) + middle[1]]).collect();
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| (j * (n + 1) + i) as u32));
    let w = n as u32 + 1;
    let indices: Vec<u32> = cells.flat_map(|c| [c, c + w, c + 1, c + 1, c + w, c + w + 1]).collect();
    let (normals, colours) = (vec![[0.0, 1.0, 0.0]; ground.len()], vec![[118, 104, 78, 255]; ground.len()]);
    let mut parts = vec![MeshPart {
        positions: &ground,
        normals: &normals,
        colours: &colours,
        indices: &indices,
        place: [0.0; 3],
        turn: 0.0,
        size: 1.0,
        shades: false,
    }];
    parts.extend(bodies.iter().map(|(b, place)| MeshPart {
        positions: &b.solid.positions,
        normals: &b.solid.normals,
        colours: &b.colours,
        indices: &b.solid.indices,
        place: *place,
        turn: 0.0,
        size: 1.0,
        shades: true,
    }));
    mesh_view(&parts, &MeshViewOptions::new(camera, [width, height], haze))
}

fn save(folder: &Path, name: &str, picture: &Picture) -> Result<()> {
    let file = std::io::BufWriter::new(std::fs::File::create(folder.join(name))?);
    let mut encoder = png::Encoder::new(file, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(picture.bytes())?;
    println!("{}", folder.join(name).display());
    Ok(())
}
