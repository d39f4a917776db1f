(* Theorem A: of a gain that is known, a Lyapunov matrix at each corner of a cell of
   plants and multipliers F, G of the whole cell put the poles of every mean of the
   corners into the region; and cells that come of cuts in halves leave out no plant. *)
From Coq Require Import ZArith QArith.
From mathcomp Require Import all_ssreflect all_algebra ssrZ zify ring.
From formal Require Export forms.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Definition pencil := (entries * entries)%type.
Definition no_pencil : pencil := (at_ [::], at_ [::]).

(* The rows [I (x) A, - I (x) E] of k copies of the loop A x = E v. *)
Definition loop N k (p : pencil) : entries := fun I J =>
  let a := (I %/ N)%N in let b := (J %/ N)%N in
  if b == a then p.2 (I %% N)%N (J %% N)%N
  else if b == (k + a)%N then Z.opp (p.1 (I %% N)%N (J %% N)%N) else Z0.

(* Minus W (x) P and the multipliers FG = [F; G] with the loop, twice their symmetric
   part. W = [alpha, beta; beta', gamma] is the region's. *)
Definition multiplied N k (W P FG : entries) (p : pencil) : entries :=
  let n := ((k + k) * N)%N in let R := memo (k * N) n (loop N k p) in
  let L := memo n n (mul (k * N) FG R) in
  memo n n (fun I J => Z.opp (Z.add
    (Z.mul (W (I %/ N)%N (J %/ N)%N) (P (I %% N)%N (J %% N)%N)) (Z.add (L I J) (L J I)))).

(* A cell: FG, and at each corner P and what shows that P and the block are definite.
   Or the cell is cut: x times the corner i plus y times j takes the place of each. *)
Definition corner := (seq (seq Z) * witness * witness)%type.
Inductive cells := Cell of seq (seq Z) & seq corner | Cut of nat & nat & Z & Z & cells & cells.
Definition no_corner : corner := ([::], no_witness, no_witness).
Definition corner_holds N k (W FG : entries) (p : pencil) (c : corner) : bool :=
  if shown N c.1.2 (at_ c.1.1) then
    shown ((k + k) * N) c.2 (multiplied N k W (at_ c.1.1) FG p)
  else false.
Definition between N (x y : Z) (p q : pencil) : pencil :=
  (memo N N (plus (times x p.1) (times y q.1)),
   memo N N (plus (times x p.2) (times y q.2))).
Fixpoint cells_hold N k W (t : cells) (ps : seq pencil) : bool :=
  match t with
  | Cell FG cs => below (size ps) (fun i =>
      corner_holds N k W (at_ FG) (nth no_pencil ps i) (nth no_corner cs i))
  | Cut i j x y s t =>
      let m := between N x y (nth no_pencil ps i) (nth no_pencil ps j) in
      if [&& (i < size ps)%N, (j < size ps)%N, i != j, Z.ltb 0 x & Z.ltb 0 y] then
        cells_hold N k W s (set_nth no_pencil ps i m)
        && cells_hold N k W t (set_nth no_pencil ps j m)
      else false
  end.

Section Meaning.
Variable C : numClosedFieldType.
Variables (N k : nat) (W : entries).
Hypothesis N_positive : (0 < N)%N.
Notation n := ((k + k) * N)%N.

(* Means with weights that needn't have the sum one. *)
Definition sum_E (ps : seq pencil) (w : nat -> C) : 'M[C]_N :=
  \sum_(i < size ps) w i *: mx C N N (nth no_pencil ps i).1.
Definition sum_A (ps : seq pencil) (w : nat -> C) : 'M[C]_N :=
  \sum_(i < size ps) w i *: mx C N N (nth no_pencil ps i).2.
Definition weights r (w : nat -> C) :=
  (forall i, (i < r)%N -> 0 <= w i) /\ exists2 i, (i < r)%N & 0 < w i.

(* (E, A) x = 0 with x = v and x' = eta: what Theorem A says of one pencil. *)
Definition negative (E A : 'M[C]_N) : Prop :=
  forall (u : 'rV[C]_(k + k)) (p : 'rV[C]_N), u != 0 -> p != 0 ->
  (forall a, (a < k)%N ->
    (ext u a)^* *: (A *m adj p) = (ext u (k + a))^* *: (E *m adj p)) ->
  herm (mx C (k + k) (k + k) W) u < 0.

Lemma conjM (a b : C) : (a * b)^* = a^* * b^*. Proof. exact: rmorphM. Qed.

Lemma loop_sum (p : pencil) (u : nat -> C) (q : 'rV[C]_N) l : (l < k * N)%N ->
  \sum_(J < n) phi C (loop N k p l J) * (krow N u (ext q) J)^*
  = (u (l %/ N)%N)^* * (\sum_(c < N) phi C (p.2 (l %% N)%N c) * (q 0 c)^*)
    - (u (k + l %/ N)%N)^* * \sum_(c < N) phi C (p.1 (l %% N)%N c) * (q 0 c)^*.
Proof.
move=> hl; pose X := \sum_(c < N) phi C (p.2 (l %% N)%N c) * (q 0 c)^*.
pose Y := \sum_(c < N) phi C (p.1 (l %% N)%N c) * (q 0 c)^*; rewrite -/X -/Y.
rewrite (sum_mul (k + k) N (fun J => phi C (loop N k p l J) * (krow N u (ext q) J)^*)).
have ha : (l %/ N < k)%N by rewrite ltn_divLR.
have edge m (o : 'I_N) : ((m * N + o) %/ N = m)%N /\ ((m * N + o) %% N = o)%N.
  by rewrite divnMDl // modnMDl divn_small ?modn_small ?addn0.
have one (b : nat) : \sum_(c < N) phi C (loop N k p l (b * N + c)%N)
      * (krow N u (ext q) (b * N + c)%N)^*
    = if b == (l %/ N)%N then (u b)^* * X
      else if b == (k + l %/ N)%N then - ((u b)^* * Y) else 0.
  rewrite /loop /krow /X /Y.
  case: eqP => [e|ne]; last case: eqP => [e|ne2].
  - rewrite mulr_sumr; apply: eq_bigr => c _; have [-> ->] := edge b c.
    rewrite e eqxx extE conjM; ring.
  - rewrite mulr_sumr -sumrN; apply: eq_bigr => c _; have [-> ->] := edge b c.
    have /negbTE -> : (b != l %/ N)%N by apply/eqP.
    rewrite e eqxx phiN extE conjM; ring.
  - apply: big1 => c _; have [-> _] := edge b c.
    have /negbTE -> : (b != l %/ N)%N by apply/eqP.
    have /negbTE -> : (b != k + l %/ N)%N by apply/eqP.
    by rewrite phi0 mul0r.
rewrite (eq_bigr _ (fun (b : 'I_(k + k)) _ => one b)) big_split_ord /=.
rewrite (bigD1 (Ordinal ha)) //= eqxx big1 => [|b]; last first.
  rewrite -val_eqE /= => /negbTE ->; case: eqP => // e.
  by have := ltn_ord b; rewrite e ltnNge leq_addr.
rewrite addr0; congr (_ + _); rewrite (bigD1 (Ordinal ha)) //= eqxx.
rewrite ifN ?big1 ?addr0 //.
  move=> b; rewrite -val_eqE /= eqn_add2l => /negbTE ->; case: eqP => // e.
  by move: ha; rewrite -e ltnNge leq_addr.
by apply/eqP => e; move: ha; rewrite -e ltnNge leq_addr.
Qed.

Lemma form_transposed m (L : entries) x :
  form m (fun i j => phi C (L j i)) x = (form m (fun i j => phi C (L i j)) x)^*.
Proof.
rewrite /form exchange_big rmorph_sum; apply: eq_bigr => i _ /=.
rewrite rmorph_sum; apply: eq_bigr => j _.
by rewrite !conjM phi_conj conjCK mulrC [x j * _]mulrC mulrA.
Qed.

Lemma form_multiplied P FG p (u : 'rV[C]_(k + k)) (q : 'rV[C]_N) :
  let z := krow N (ext u) (ext q) in
  let l := form n (fun I J => phi C (mul (k * N) FG (loop N k p) I J)) z in
  form n (fun I J => phi C (multiplied N k W P FG p I J)) z
  = - (herm (mx C (k + k) (k + k) W) u * herm (mx C N N P) q + (l + l^*)).
Proof.
move=> z l; rewrite -!form_herm -form_kron // /l -form_transposed -!formD -formN.
apply: eq_form => I J hI hJ; rewrite /multiplied memoE // phiN !phiD phiM !memoE //.
have same a b : (a < n)%N -> (b < n)%N -> phi C (mul (k * N) FG (memo (k * N) n (loop N k p)) a b)
    = phi C (mul (k * N) FG (loop N k p) a b).
  move=> ha hb; rewrite /mul !phi_sum; apply: eq_bigr => i _.
  by rewrite memoE.
by rewrite !same.
Qed.

Lemma form_through FG p z :
  form n (fun I J => phi C (mul (k * N) FG (loop N k p) I J)) z
  = \sum_(l < k * N) (\sum_(I < n) z I * phi C (FG I l))
      * \sum_(J < n) phi C (loop N k p l J) * (z J)^*.
Proof.
transitivity (\sum_(I < n) \sum_(l < k * N) (z I * phi C (FG I l))
    * \sum_(J < n) phi C (loop N k p l J) * (z J)^*).
  apply: eq_bigr => I _.
  transitivity (\sum_(J < n) \sum_(l < k * N)
      z I * phi C (FG I l) * (phi C (loop N k p l J) * (z J)^*)).
    apply: eq_bigr => J _; rewrite phi_sum mulr_sumr mulr_suml.
    by apply: eq_bigr => l _; rewrite phiM; ring.
  by rewrite exchange_big; apply: eq_bigr => l _; rewrite mulr_sumr.
by rewrite exchange_big; apply: eq_bigr => l _; rewrite mulr_suml.
Qed.

Lemma cell_negative FG cs ps w : cells_hold N k W (Cell FG cs) ps ->
  weights (size ps) w -> negative (sum_E ps w) (sum_A ps w).
Proof.
move=> /= /belowP each [w0 [i0 hi0 pos]] u q u0 q0 motion.
pose z := krow N (ext u) (ext q).
pose l i := form n (fun I J =>
  phi C (mul (k * N) (at_ FG) (loop N k (nth no_pencil ps i)) I J)) z.
pose P i := herm (mx C N N (at_ (nth no_corner cs i).1.1)) q.
have none : \sum_(i < size ps) w i * l i = 0.
  transitivity (\sum_(i < size ps) \sum_(a < k * N)
      (\sum_(I < n) z I * phi C (at_ FG I a))
      * (w i * \sum_(J < n) phi C (loop N k (nth no_pencil ps i) a J) * (z J)^*)).
    by apply: eq_bigr => i _; rewrite /l form_through mulr_sumr; apply: eq_bigr => a _; ring.
  rewrite exchange_big big1 // => a _; rewrite -mulr_sumr.
  have ha : (a %/ N < k)%N by rewrite ltn_divLR // ltn_ord.
  have hr : (a %% N < N)%N by rewrite ltn_mod.
  rewrite (eq_bigr (fun i : 'I_(size ps) => (ext u (a %/ N)%N)^*
      * (w i * (\sum_(c < N) phi C ((nth no_pencil ps i).2 (a %% N)%N c) * (q 0 c)^*))
    - (ext u (k + a %/ N)%N)^*
      * (w i * \sum_(c < N) phi C ((nth no_pencil ps i).1 (a %% N)%N c) * (q 0 c)^*)));
    last by move=> i _; rewrite loop_sum //; ring.
  rewrite sumrB -!mulr_sumr.
  have row (f : pencil -> entries) : \sum_(i < size ps)
      w i * (\sum_(c < N) phi C (f (nth no_pencil ps i) (a %% N)%N c) * (q 0 c)^*)
      = ((\sum_(i < size ps) w i *: mx C N N (f (nth no_pencil ps i))) *m adj q)
          (Ordinal hr) 0.
    rewrite mulmx_suml summxE; apply: eq_bigr => i _.
    rewrite -scalemxAl !mxE; congr (_ * _); apply: eq_bigr => c _.
    by rewrite !mxE.
  rewrite (row snd) (row fst); have := motion _ ha.
  by move=> /matrixP/(_ (Ordinal hr) 0); rewrite !mxE => ->; rewrite subrr mulr0.
have block i : (i < size ps)%N ->
    herm (mx C (k + k) (k + k) W) u * P i + (l i + (l i)^*) < 0 /\ 0 < P i.
  move=> hi; have := each i hi; rewrite /corner_holds; case: ifP => // sP sB.
  split; last exact: shown_sound sP q0.
  rewrite -oppr_gt0 /P /l -form_multiplied.
  by apply: (definite_sound sB); exact: krow_nonzero.
have conj_w (i : 'I_(size ps)) : (w i)^* = w i by rewrite conj_Creal ?ger0_real ?w0.
have sum_pos : 0 < \sum_(i < size ps) w i * P i.
  rewrite (bigD1 (Ordinal hi0)) //=; apply: ltr_paddr; last by
    rewrite mulr_gt0 //; have [] := block i0 hi0.
  by apply: sumr_ge0 => i _; rewrite mulr_ge0 ?w0 // ltW //; have [] := block i (ltn_ord i).
rewrite -(pmulr_llt0 _ sum_pos).
have -> : herm (mx C (k + k) (k + k) W) u * (\sum_(i < size ps) w i * P i)
   = \sum_(i < size ps) w i
       * (herm (mx C (k + k) (k + k) W) u * P i + (l i + (l i)^*)).
  rewrite [RHS](eq_bigr (fun i : 'I_(size ps) => herm (mx C (k + k) (k + k) W) u * (w i * P i)
      + (w i * l i + (w i * l i)^*))).
    by rewrite big_split /= big_split /= none -rmorph_sum none rmorph0 !addr0 mulr_sumr.
  by move=> i _; rewrite conjM conj_w; ring.
rewrite (bigD1 (Ordinal hi0)) //= -oppr_gt0 opprD; apply: ltr_paddr.
  rewrite -sumrN; apply: sumr_ge0 => i _; rewrite -mulrN mulr_ge0 ?w0 //.
  by rewrite ltW // oppr_gt0; have [] := block i (ltn_ord i).
by rewrite -mulrN mulr_gt0 // oppr_gt0; have [] := block i0 hi0.
Qed.

Lemma part_sum (f : pencil -> entries) ps i j m (x y : C) (w : nat -> C) :
  (i < size ps)%N -> (j < size ps)%N -> i != j -> 0 < y ->
  mx C N N (f m)
  = x *: mx C N N (f (nth no_pencil ps i)) + y *: mx C N N (f (nth no_pencil ps j)) ->
  \sum_(a < size ps) w a *: mx C N N (f (nth no_pencil ps a))
  = \sum_(a < size ps) (if a == i :> nat then w i - w j / y * x else if a == j :> nat then w j / y else w a)
      *: mx C N N (f (nth no_pencil (set_nth no_pencil ps j m) a)).
Proof.
move=> hi hj ne y0 mid; have ji : (j == i) = false by rewrite eq_sym; exact: negbTE.
rewrite (bigD1 (Ordinal hi)) // (bigD1 (Ordinal hj)) /= -?val_eqE /= ?ji //.
rewrite [RHS](bigD1 (Ordinal hi)) // [X in _ = _ + X](bigD1 (Ordinal hj)) /= -?val_eqE /= ?ji //.
rewrite !nth_set_nth /= !eqxx (negbTE ne) mid !addrA; congr (_ + _).
  by rewrite scalerBl scalerDr !scalerA divfK ?gt_eqF // addrA subrK.
apply: eq_bigr => a /andP[ai aj]; rewrite nth_set_nth /=.
by rewrite -!val_eqE /= in ai aj; rewrite (negbTE ai) (negbTE aj).
Qed.

Lemma mx_between x y p q :
  mx C N N (between N x y p q).1 = phi C x *: mx C N N p.1 + phi C y *: mx C N N q.1
  /\ mx C N N (between N x y p q).2 = phi C x *: mx C N N p.2 + phi C y *: mx C N N q.2.
Proof. by rewrite /between !mx_memo !mx_plus !mx_times. Qed.

Lemma part_negative ps i j m (x y : C) (w : nat -> C) :
  (i < size ps)%N -> (j < size ps)%N -> i != j -> 0 < x -> 0 < y -> w j * x <= w i * y ->
  let p := nth no_pencil ps i in let q := nth no_pencil ps j in
  mx C N N m.1 = x *: mx C N N p.1 + y *: mx C N N q.1 ->
  mx C N N m.2 = x *: mx C N N p.2 + y *: mx C N N q.2 ->
  weights (size ps) w ->
  (forall v, weights (size (set_nth no_pencil ps j m)) v ->
    negative (sum_E (set_nth no_pencil ps j m) v) (sum_A (set_nth no_pencil ps j m) v)) ->
  negative (sum_E ps w) (sum_A ps w).
Proof.
move=> hi hj ne x0 y0 le p q m1 m2 [w0 [i0 hi0 pos]].
have same : size (set_nth no_pencil ps j m) = size ps.
  by rewrite size_set_nth; apply/maxn_idPr.
pose v a := if a == i then w i - w j / y * x else if a == j then w j / y else w a.
have y1 : 0 < y^-1 by rewrite invr_gt0.
move=> /(_ v); rewrite /sum_E /sum_A same.
rewrite -(@part_sum fst ps i j m x y w) // -(@part_sum snd ps i j m x y w) //; apply; split.
  move=> a ha; rewrite /v; case: eqP => _; last case: eqP => _; last exact: w0.
    by rewrite subr_ge0 mulrAC ler_pdivr_mulr.
  by rewrite mulr_ge0 ?w0 // ltW.
have := w0 j hj; rewrite le_eqVlt => /orP[/eqP z|z].
  have i0j : i0 != j by apply: contraTneq pos => ->; rewrite -z ltxx.
  by exists i0 => //; rewrite /v (negbTE i0j) -z !mul0r subr0; case: eqP => [<-|].
by exists j => //; rewrite /v eqxx eq_sym (negbTE ne) mulr_gt0.
Qed.

Theorem cells_negative t : forall ps w, cells_hold N k W t ps ->
  weights (size ps) w -> negative (sum_E ps w) (sum_A ps w).
Proof.
elim: t => [FG cs|i j x y s IHs t IHt] ps w; first exact: cell_negative.
rewrite [cells_hold _ _ _ _ _]/=; case: ifP => // /and5P[hi hj ne x0 y0] /andP[hs ht] ww.
set p := nth no_pencil ps i in hs ht; set q := nth no_pencil ps j in hs ht.
have [m1 m2] := mx_between x y p q; have [w0 _] := ww.
have [px py] := (phi_gt0 C x0, phi_gt0 C y0).
have /orP[le|le] : (w j * phi C x <= w i * phi C y) || (w i * phi C y <= w j * phi C x).
  by apply: real_leVge; rewrite ger0_real // mulr_ge0 ?w0 // ltW.
  by apply: (part_negative hi hj ne px py le m1 m2 ww) => v; exact: IHt.
rewrite eq_sym in ne; rewrite addrC in m1; rewrite addrC in m2.
by apply: (part_negative hj hi ne py px le m1 m2 ww) => v; exact: IHs.
Qed.
End Meaning.

(* s lies where (v, s* v) W (v, s* v)* < 0 for all rows v. *)
Definition in_square k (W : numbers) : place := fun C s => forall v : 'rV[C]_k, v != 0 ->
  herm (real C (k + k) (k + k) W) (row_mx v (s^* *: v)) < 0.
Arguments in_square k W C s : clear implicits.

Theorem cells_sound N k W (g : Z) t pencils (R : place) :
  (forall C s, in_square k.+1 W C s -> R C s) ->
  [&& (0 < N)%N, Z.ltb 0 g, is_whole g W, Z.leb 0 (whole g W k.+1 k.+1)
    & cells_hold N k.+1 (memo (k.+1 + k.+1) (k.+1 + k.+1) (whole g W)) t pencils] ->
  decided N R pencils.
Proof.
move=> inside /and5P[N0 g0 wW corner holds] C r w size_r w0 w1; subst r.
pose v i := if insub i is Some o then w o else 0.
have vE (i : 'I_(size pencils)) : v i = w i by rewrite /v valK.
have [E A] : E_mean N pencils w = sum_E N pencils v /\ A_mean N pencils w = sum_A N pencils v.
  by split; apply: eq_bigr => i _; rewrite vE.
have vw : weights (size pencils) v.
  split=> [i hi|]; first by rewrite (vE (Ordinal hi)) // w0.
  have /existsP[i wi] : [exists i, w i != 0].
    apply/contraT => /existsPn all0; move: w1; rewrite big1 => [/eqP|i _].
      by rewrite eq_sym oner_eq0.
    by apply/eqP; have := all0 i; rewrite negbK.
  by exists i => //; rewrite vE lt_def wi w0.
have := cells_negative N0 holds vw; rewrite /negative -E -A mx_memo => neg.
have adj0 a (x : 'cV[C]_a) : x != 0 -> exists2 y : 'rV[C]_a, y != 0 & adj y = x.
  move=> x0; exists (adj x); last by apply/matrixP => i j; rewrite !mxE conjCK.
  by case/cV0Pn: x0 => i xi; apply/rV0Pn; exists i; rewrite !mxE conjC_eq0.
have right0 (X : 'M[C]_N) : \det X = 0 -> exists2 q : 'rV[C]_N, q != 0 & X *m adj q = 0.
  rewrite -det_tr => /eqP/det0P[q q0 qX].
  have [|y y0 e] := adj0 _ q^T; first by rewrite trmx_eq0.
  by exists y; rewrite // e -[X]trmxK -trmx_mul qX trmx0.
split.
  apply/eqP => /right0[q q0 Eq].
  have : herm (mx C (k.+1 + k.+1) (k.+1 + k.+1) (whole g W)) (row_mx 0 (delta_mx 0 0)) < 0.
    apply: (neg _ q) => // [|a ha].
      by apply/rV0Pn; exists (rshift k.+1 0); rewrite row_mxEr mxE !eqxx oner_neq0.
    rewrite Eq scaler0 (extE _ (lshift k.+1 (Ordinal ha))) row_mxEl mxE conjC0.
    by rewrite scale0r.
  suff ge : 0 <= herm (mx C (k.+1 + k.+1) (k.+1 + k.+1) (whole g W)) (row_mx 0 (delta_mx 0 0)).
    by move=> /(le_lt_trans ge); rewrite ltxx.
  rewrite /herm /sesqui.
  rewrite -[mx _ _ _ _]submxK mul_row_block !mul0mx !add0r.
  have -> : adj (row_mx 0 (delta_mx 0 0)) = col_mx 0 (delta_mx 0 0) :> 'cV[C]_(k.+1 + k.+1).
    apply/matrixP => i j; rewrite !mxE; case: splitP => a _; rewrite !mxE ?conjC0 // !ord1.
    by rewrite andbC; case: eqP => _; rewrite ?conjC1 ?conjC0.
  rewrite mul_row_col mulmx0 add0r -rowE -colE !mxE.
  by rewrite /= addn0; exact: phi_ge0.
move=> s pole; apply: inside => v' nz.
have /right0[q q0] := pole; rewrite mulmxBl -scalemxAl => /eqP; rewrite subr_eq0 => /eqP sE.
have : herm (mx C (k.+1 + k.+1) (k.+1 + k.+1) (whole g W)) (row_mx v' (s^* *: v')) < 0.
  apply: (neg _ q) => // [|a ha]; first by rewrite row_mx_eq0 negb_and nz.
  rewrite (extE _ (lshift k.+1 (Ordinal ha))) (extE _ (rshift k.+1 (Ordinal ha))).
  by rewrite row_mxEl row_mxEr !mxE conjM conjCK -sE scalerA mulrC.
rewrite mx_whole // /herm /sesqui -scalemxAr -scalemxAl mxE pmulr_rlt0 //.
exact: phi_gt0.
Qed.

(* W of matrices alpha, beta of a region, and of a disk, which is k = 1 alone. *)
Definition square k (alpha beta gamma : numbers) : numbers :=
  mkseq (fun i => mkseq (fun j =>
    if (i < k)%N then if (j < k)%N then entry alpha i j else entry beta i (j - k)
    else if (j < k)%N then entry beta j (i - k) else entry gamma (i - k) (j - k))
    (k + k)) (k + k).
Definition of_disk (rho centre : Q) : numbers :=
  square 1 [:: [:: Qplus (Qmult centre centre) (Qopp (Qmult rho rho))]]
    [:: [:: Qopp centre]] [:: [:: one]].

Lemma in_squareE k alpha beta gamma (C : numClosedFieldType) (s : C) (v : 'rV[C]_k) :
  herm (real C (k + k) (k + k) (square k alpha beta gamma)) (row_mx v (s^* *: v))
  = herm (real C k k alpha + s *: real C k k beta + s^* *: (real C k k beta)^T
      + (s * s^*) *: real C k k gamma) v.
Proof.
have -> : real C (k + k) (k + k) (square k alpha beta gamma)
    = block_mx (real C k k alpha) (real C k k beta) (real C k k beta)^T (real C k k gamma).
  apply/matrixP => i j; rewrite !mxE /square nth_mkseq // nth_mkseq //.
  by case: (splitP i) => a ea; rewrite !mxE; case: (splitP j) => b eb;
     rewrite !mxE ea eb ?ltn_ord ?ltnNge ?leq_addr ?addKn.
rewrite /herm /sesqui; have -> : adj (row_mx v (s^* *: v)) = col_mx (adj v) (s *: adj v).
  rewrite /adj map_row_mx tr_row_mx; congr col_mx.
  by apply/matrixP => a b; rewrite !mxE conjM conjCK.
rewrite mul_row_block mul_row_col -!scalemxAl !mulmxDr !mulmxDl.
rewrite -!scalemxAr -!scalemxAl !scalerA !mxE !addrA.
by congr (_ + _); exact: addrAC.
Qed.

Theorem square_sound k alpha beta (C : numClosedFieldType) (s : C) :
  in_square k (square k alpha beta [::]) C s -> in_matrices k alpha beta C s.
Proof.
move=> inside v v0; have := inside v v0; rewrite in_squareE.
have -> : real C k k [::] = 0; last by rewrite scaler0 addr0.
by apply/matrixP => i j; rewrite !mxE !nth_nil phiQ0.
Qed.

Lemma phiQD (C : numClosedFieldType) a b : phiQ C (Qplus a b) = phiQ C a + phiQ C b.
Proof.
by rewrite /phiQ /= (phiM C (Zpos _) (Zpos _)) phiD !phiM addf_div ?phi_pos.
Qed.

Theorem of_disk_sound rho centre (C : numClosedFieldType) (s : C) : Qle_bool zero rho ->
  in_square 1 (of_disk rho centre) C s -> in_disk rho centre C s.
Proof.
move=> /(phiQ_le C); rewrite phiQ0 => r0 /(_ 1%:M ltac:(by rewrite oner_neq0)).
rewrite in_squareE /herm /sesqui mul1mx !mxE big_ord1 !mxE /= rmorph1 mulr1.
rewrite phiQD !phiQN !phiQM phiQ1 => neg.
have c_real := phiQ_real C centre.
rewrite /in_disk -(ltr_pexpn2r (ltn0Sn 1)) ?nnegrE // normCK.
rewrite rmorphB /= (CrealP c_real) -subr_lt0.
congr (_ < 0): neg; ring.
Qed.
