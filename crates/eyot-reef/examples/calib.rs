use eyot_reef::community::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let side: f64 = a[1].parse().unwrap();
    let months: u64 = a[2].parse().unwrap();
    let from: u64 = a[3].parse().unwrap();
    let seeds: u64 = a[4].parse().unwrap();
    let compat = a.get(5).map_or(true, |s| s == "compat");
    let mut stats: Vec<Vec<f64>> = Vec::new();
    let mut names = Vec::new();
    let mut maxes = vec![];
    let mut mins = vec![];
    let t = std::time::Instant::now();
    for seed in 0..seeds {
        let c = Community { compat, ..Default::default() };
        let f = Forcing::chumbe(&c, seed).unwrap();
        let mut p = Plot::new(c, Site::flat(side, side), f, seed).unwrap();
        let mut sums: Vec<f64> = vec![];
        for m in 0..months {
            let s = p.month().unwrap();
            let mut row: Vec<(String, f64)> = vec![];
            for (i, x) in s.species.iter().enumerate() {
                row.push((format!("n{i}"), x.colonies as f64));
                row.push((format!("c{i}%"), 100.0 * x.cover));
            }
            row.push(("corals".into(), s.colonies() as f64));
            row.push(("cover%".into(), 100.0 * s.coral_cover()));
            row.push(("algae".into(), s.algae as f64));
            row.push(("algae%".into(), 100.0 * s.algae_cover));
            row.push(("turf".into(), s.turf_cover));
            row.push(("rug".into(), s.rugosity));
            row.push(("graze".into(), s.grazing as f64));
            row.push(("lime mm/yr".into(), s.limestone_m * 12e3));
            if seed == 0 && (m == 0 || m == 12) { println!("m{m}: {:?}", row.iter().map(|r| format!("{}={:.2}", r.0, r.1)).collect::<Vec<_>>()); }
            if m >= from {
                if sums.is_empty() { sums = vec![0.0; row.len()]; if maxes.is_empty() { maxes = vec![0f64; row.len()]; mins = vec![1e9f64; row.len()]; names = row.iter().map(|r| r.0.clone()).collect(); } }
                for (i, r) in row.iter().enumerate() { sums[i] += r.1; maxes[i] = maxes[i].max(r.1); mins[i] = mins[i].min(r.1); }
            }
        }
        stats.push(sums.iter().map(|s| s / (months - from) as f64).collect());
    }
    println!("{:.2} ms a month", t.elapsed().as_secs_f64() * 1e3 / (months * seeds) as f64);
    for (i, n) in names.iter().enumerate() {
        let v: Vec<f64> = stats.iter().map(|s| s[i]).collect();
        let mean = v.iter().sum::<f64>() / v.len() as f64;
        let sd = (v.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (v.len() - 1) as f64).sqrt();
        let (lo, hi) = v.iter().fold((f64::MAX, 0f64), |a, &x| (a.0.min(x), a.1.max(x)));
        println!("{n:>12} {mean:9.2} +- {sd:7.2}  runs {lo:8.2} .. {hi:8.2}  months {:8.2} .. {:8.2}", mins[i], maxes[i]);
    }
}
